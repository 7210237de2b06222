// From sliders to the weights of morph targets, as `extras.elastomorph` of a glTF mesh says.
//
// One header, C++17, no dependency, no exceptions of its own. Read once, asked in every frame:
//
//     std::string problem;
//     auto bender = elastomorph::Bender::from_json(extras, problem);   // the extras of the mesh
//     if (!bender) return fail(problem);
//     bender->weights(sliders, weights);   // in the order of bender->sliders() and ->targets()
//
// Version 0.2.0. SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <locale>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace elastomorph {

/// A JSON value, read with a limit of depth. Texts are UTF-8.
struct Json {
    enum class Kind { null, boolean, number, text, list, object };
    Kind kind = Kind::null;
    double number = 0;
    std::string text;
    std::vector<Json> list;
    std::vector<std::pair<std::string, Json>> object;

    /// The last value of a key, or null; of anything but an object, null.
    const Json* get(std::string_view key) const {
        for (auto own = object.rbegin(); own != object.rend(); ++own)
            if (own->first == key) return &own->second;
        return nullptr;
    }

    /// Nothing where the text is no JSON.
    static std::optional<Json> read(std::string_view text);
};

/// A piecewise polynomial: between breaks i and i + 1 Σ_n coefficients[i][n] (t − breaks[i])^n.
struct Curve {
    std::vector<double> breaks;
    std::vector<std::vector<double>> coefficients;
};

/// A morph target: the one of its name, or of several of a name that of its number.
struct Target {
    std::string name;
    std::size_t index = std::numeric_limits<std::size_t>::max();
};

/// What is said of a path; filled by hand, or from extras by `describe`.
struct Morph {
    struct Bend {
        Target target;
        Curve curve;
    };
    std::string name;
    Target target;
    std::vector<Bend> bends = {};
    std::optional<Curve> fold = std::nullopt;
    bool whole = true;  // false of a pair bend, which has bends and no target
};

/// How the weight of a corrective comes of those of its drivers.
enum class Law { product, min, softmin, hinge, all_mul, ext_mul, mul_avg_ext, mul_avg_all };

/// A morph that several sliders drive.
struct Corrective {
    std::string name;
    std::vector<std::string> drivers;
    Law law = Law::product;
    std::vector<double> gains = {};  // of hinge, one a driver
    double sharpness = 0;            // of softmin, above 0
};

/// What is said of a mesh. Targets that no morph names are straight paths of their own.
struct Description {
    std::vector<std::string> targets;
    std::vector<Morph> morphs = {};
    std::vector<Corrective> correctives = {};
};

/// The description in the extras of a mesh: an object with `targetNames` and `elastomorph`.
inline std::optional<Description> describe(const Json& extras, std::string& problem);

/// The extras of a mesh in a file of curves; null where there is none, or several have the name.
inline const Json* curves_of(const Json& curves, std::string_view mesh);

/// The weights of one mesh: made once, asked in every frame.
class Bender {
public:
    /// Nothing, and a problem, where the description does not fit together.
    static std::optional<Bender> from(const Description& described, std::string& problem);

    /// From the extras of a mesh, or from a file of curves and the name of the mesh, of its node, or
    /// its number; of one mesh without any.
    static std::optional<Bender> from_json(std::string_view text, std::string& problem,
                                           std::string_view mesh = {}) {
        const auto json = Json::read(text);
        if (!json) return problem = "the extras are no JSON", std::nullopt;
        const Json* extras = json->get("meshes") ? curves_of(*json, mesh) : &*json;
        if (!extras) return problem = "the file of curves has not one mesh of that name", std::nullopt;
        const auto described = describe(*extras, problem);
        return described ? from(*described, problem) : std::nullopt;
    }

    /// Names of the sliders, in the order of their values.
    const std::vector<std::string>& sliders() const { return sliders_; }

    /// Names of the morph targets, in the order of their weights.
    const std::vector<std::string>& targets() const { return targets_; }

    /// Reads sliders().size() values and writes targets().size() weights; allocates nothing.
    template <class Real>
    void weights(const Real* values, Real* out) const {
        for (const Path& path : paths_) {
            const double t = time(path, values);
            for (std::size_t b = 0; b < path.weighings; ++b) {
                const Weighing& own = weighings_[path.first_weighing + b];
                out[own.target] = static_cast<Real>((own.from_t ? t : 0) + at(own, t));
            }
        }
    }

private:
    /// The weight of a target: t, if from_t, and a curve, if it has pieces.
    struct Weighing {
        std::size_t target, first, pieces, terms;
        double start_slope, end_slope;
        bool from_t;
    };
    struct Driver {
        std::size_t slider;
        double gain;  // 1 but of a hinge
    };
    struct Path {
        std::size_t first_driver, drivers, first_weighing, weighings;
        Law law;
        double sharpness;
    };

    template <class Real>
    double time(const Path& path, const Real* values) const {
        const Driver* first = drivers_.data() + path.first_driver;
        const Driver* last = first + path.drivers;
        const auto count = static_cast<double>(path.drivers);
        const bool clamped = path.law >= Law::all_mul;
        double product = 1, sum = 0, low = std::numeric_limits<double>::max(), high = 0;
        for (const Driver* own = first; own != last; ++own) {
            const double value = values[own->slider];
            const double finite = std::isfinite(value) ? value : 0;
            const double w = clamped ? std::min(finite, 1.0) : finite;
            product *= w;
            sum += own->gain * w;
            low = std::min(low, w);
            high = std::max(high, w);
        }
        if (path.law == Law::product) return product;
        if (path.law == Law::hinge) return std::max(0.0, sum - 1);
        if (low <= 0) return 0;
        double mean = 0;  // of powers relative to the least, so that none overflows
        switch (path.law) {
            case Law::min: return low;
            case Law::ext_mul: return low * high;
            case Law::mul_avg_ext: return 2 * low * high / (low + high);
            case Law::mul_avg_all: return count * product / sum;
            case Law::softmin:
                for (const Driver* own = first; own != last; ++own)
                    mean += std::pow(low / static_cast<double>(values[own->slider]), path.sharpness);
                return low * std::pow(mean / count, -1 / path.sharpness);
            default: return product;
        }
    }

    double at(const Weighing& own, double t) const {
        if (own.pieces == 0) return 0;
        if (t <= 0) return own.start_slope * t;
        if (t >= 1) return own.end_slope * (t - 1);
        const double* breaks = breaks_.data() + own.first;
        const auto later = std::upper_bound(breaks, breaks + own.pieces, t);
        const auto piece = static_cast<std::size_t>(later - breaks) - 1;
        const double* terms = terms_.data() + rows_[own.first + piece];
        double sum = 0;
        for (std::size_t n = own.terms; n-- > 0;) sum = sum * (t - breaks[piece]) + terms[n];
        return sum;
    }

    bool add(std::size_t target, bool from_t, const Curve* curve);

    /// The number of a target; as many as there are where it is none of them.
    std::size_t number_of(const Target& target) const {
        if (target.index < targets_.size() && targets_[target.index] == target.name)
            return target.index;
        const auto found = std::find(targets_.begin(), targets_.end(), target.name);
        const bool one = std::count(found, targets_.end(), target.name) == 1;
        return one ? static_cast<std::size_t>(found - targets_.begin()) : targets_.size();
    }

    std::vector<std::string> sliders_, targets_;
    std::vector<Path> paths_;
    std::vector<Driver> drivers_;
    std::vector<Weighing> weighings_;
    std::vector<double> breaks_, terms_;  // of all curves, one after another; a break a piece
    std::vector<std::size_t> rows_;       // where the terms of each piece begin
};

inline bool Bender::add(std::size_t target, bool from_t, const Curve* curve) {
    Weighing own{target, breaks_.size(), 0, 0, 0, 0, from_t};
    if (curve) {
        const auto& [breaks, rows] = *curve;
        if (rows.empty() || breaks.size() != rows.size() + 1) return false;
        if (breaks.front() != 0 || breaks.back() != 1 || rows[0].empty() || rows[0].size() > 256)
            return false;
        double largest = 1;
        for (std::size_t i = 0; i < rows.size(); ++i) {
            if (!(breaks[i] < breaks[i + 1]) || rows[i].size() != rows[0].size()) return false;
            for (const double term : rows[i]) {
                if (!std::isfinite(term)) return false;
                largest = std::max(largest, std::abs(term));
            }
            breaks_.push_back(breaks[i]);
            rows_.push_back(terms_.size());
            terms_.insert(terms_.end(), rows[i].begin(), rows[i].end());
        }
        own.pieces = rows.size();
        own.terms = rows[0].size();
        own.start_slope = own.terms > 1 ? rows[0][1] : 0;
        const double width = 1 - breaks[rows.size() - 1];
        double end = 0;
        for (std::size_t n = own.terms; n-- > 0;) {
            end = end * width + rows.back()[n];
            if (n == 0) break;
            own.end_slope = own.end_slope * width + static_cast<double>(n) * rows.back()[n];
        }
        if (!(std::max(std::abs(rows[0][0]), std::abs(end)) <= 1e-9 * largest)) return false;
    }
    weighings_.push_back(own);
    return true;
}

inline std::optional<Bender> Bender::from(const Description& described, std::string& problem) {
    const auto refuse = [&problem](std::string why) {
        problem = std::move(why);
        return std::nullopt;
    };
    Bender made;
    made.targets_ = described.targets;
    std::vector<bool> used(described.targets.size());
    std::vector<Morph> morphs = described.morphs;
    for (Morph& morph : morphs)
        for (std::size_t b = morph.whole ? 0 : 1; b <= morph.bends.size(); ++b) {
            Target& target = b == 0 ? morph.target : morph.bends[b - 1].target;
            target.index = made.number_of(target);
            if (target.index == used.size() || used[target.index])
                return refuse("morph target " + target.name + " is missing or used twice");
            used[target.index] = true;
        }
    for (std::size_t i = 0; i < used.size(); ++i)
        if (!used[i]) morphs.push_back({described.targets[i], {described.targets[i], i}});

    std::map<std::string, const Corrective*> correctives;
    std::set<std::string> names;
    for (const Morph& morph : morphs)
        if (!names.insert(morph.name).second) return refuse("two morphs named " + morph.name);
    for (const Corrective& own : described.correctives) {
        if (!names.count(own.name) || !correctives.emplace(own.name, &own).second)
            return refuse("corrective " + own.name + " is no morph, or given twice");
        if (own.drivers.empty()) return refuse("corrective " + own.name + " has no drivers");
        const auto finite = [](double number) { return std::isfinite(number); };
        if (own.gains.size() != (own.law == Law::hinge ? own.drivers.size() : 0) ||
            !std::all_of(own.gains.begin(), own.gains.end(), finite) ||
            (own.law == Law::softmin && !(finite(own.sharpness) && own.sharpness > 0)))
            return refuse("the numbers of the law of " + own.name + " do not fit");
    }
    std::map<std::string, std::size_t> column;
    for (const Morph& morph : morphs) {
        const auto found = correctives.find(morph.name);
        const auto drives = [&](const Corrective& own) {
            return std::count(own.drivers.begin(), own.drivers.end(), own.name) > 0;
        };
        if (found != correctives.end() && !drives(*found->second)) continue;
        if (!morph.whole) return refuse(morph.name + " has a slider and no target");
        column.emplace(morph.name, made.sliders_.size());
        made.sliders_.push_back(morph.name);
    }
    for (const Morph& morph : morphs) {
        const std::size_t first = morph.whole ? 0 : 1;
        const auto found = correctives.find(morph.name);
        const Corrective alone{morph.name, {morph.name}};
        const Corrective& driven = found == correctives.end() ? alone : *found->second;
        made.paths_.push_back({made.drivers_.size(), driven.drivers.size(), made.weighings_.size(),
                               1 - first + morph.bends.size(), driven.law, driven.sharpness});
        for (std::size_t d = 0; d < driven.drivers.size(); ++d) {
            const std::string& driver = driven.drivers[d];
            const auto slider = column.find(driver);
            if (slider == column.end() || (driver != morph.name && correctives.count(driver)))
                return refuse("driver " + driver + " of " + morph.name + " is no slider");
            made.drivers_.push_back({slider->second, driven.gains.empty() ? 1 : driven.gains[d]});
        }
        for (std::size_t b = first; b <= morph.bends.size(); ++b) {
            const Curve* fold = morph.fold ? &*morph.fold : nullptr;
            const Target& target = b == 0 ? morph.target : morph.bends[b - 1].target;
            if (!made.add(target.index, b == 0, b == 0 ? fold : &morph.bends[b - 1].curve))
                return refuse("a curve of " + morph.name + " is damaged");
        }
    }
    return made;
}

namespace detail {

constexpr int newest = 3, most_depth = 64;

inline bool is(const Json* json, Json::Kind kind) { return json && json->kind == kind; }

/// The entries of a list; an empty one may have been left out.
inline bool entries(const Json& holder, std::string_view key, std::vector<const Json*>& out) {
    const Json* found = holder.get(key);
    if (!found) return true;
    if (found->kind != Json::Kind::list) return false;
    for (const Json& entry : found->list) out.push_back(&entry);
    return true;
}

inline bool texts(const Json* json, std::vector<std::string>& out) {
    if (!is(json, Json::Kind::list)) return false;
    for (const Json& entry : json->list) {
        if (entry.kind != Json::Kind::text) return false;
        out.push_back(entry.text);
    }
    return true;
}

inline bool numbers(const Json* json, std::vector<double>& out) {
    if (!is(json, Json::Kind::list)) return false;
    for (const Json& entry : json->list) {
        if (entry.kind != Json::Kind::number) return false;
        out.push_back(entry.number);
    }
    return true;
}

inline bool curve(const Json* json, Curve& out) {
    if (!json || !numbers(json->get("breaks"), out.breaks)) return false;
    const Json* rows = json->get("coefficients");
    if (!is(rows, Json::Kind::list)) return false;
    for (const Json& row : rows->list)
        if (!numbers(&row, out.coefficients.emplace_back())) return false;
    return true;
}

inline bool text(const Json& holder, std::string_view key, std::string& out) {
    const Json* found = holder.get(key);
    if (!is(found, Json::Kind::text)) return false;
    out = found->text;
    return true;
}

inline bool target(const Json& json, double version, Target& out) {
    const Json* index = json.get("index");
    const double number = version > 2 && is(index, Json::Kind::number) ? index->number : -1;
    if (number >= 0 && number < 1e9 && std::fmod(number, 1) == 0)
        out.index = static_cast<std::size_t>(number);
    return text(json, "target", out.name);
}

inline bool morph(const Json& json, double version, Morph& out) {
    std::vector<const Json*> bends;
    out.whole = version < 3 || json.get("target");
    if (!text(json, "name", out.name)) return false;
    if (out.whole && !target(json, version, out.target)) return false;
    if (!entries(json, "bends", bends)) return false;
    for (const Json* bend : bends) {
        auto& own = out.bends.emplace_back();
        if (!target(*bend, version, own.target) || !curve(bend->get("curve"), own.curve))
            return false;
    }
    const Json* fold = json.get("fold");
    return version < 2 || !fold || curve(fold, out.fold.emplace());
}

inline bool corrective(const Json& json, double version, Corrective& out) {
    if (!text(json, "name", out.name) || !texts(json.get("drivers"), out.drivers)) return false;
    if (version < 3) return true;
    static constexpr std::string_view names[] = {"product", "min",    "softmin",   "hinge",
                                                 "allMul",  "extMul", "mulAvgExt", "mulAvgAll"};
    std::string law = "product";
    if (json.get("law") && !text(json, "law", law)) return false;
    const auto found = std::find(std::begin(names), std::end(names), law);
    if (found == std::end(names)) return false;
    out.law = static_cast<Law>(found - std::begin(names));
    const Json* gains = json.get("gains");
    const Json* sharpness = json.get("sharpness");
    if ((gains != nullptr) != (out.law == Law::hinge)) return false;
    if ((sharpness != nullptr) != (out.law == Law::softmin)) return false;
    if (sharpness) out.sharpness = sharpness->number;  // 0 where it is none
    return !gains || numbers(gains, out.gains);
}

/// Reads JSON. Where `failed`, the rest is not looked at.
struct Reader {
    std::string_view text;
    std::size_t at = 0;
    bool failed = false;
    std::istringstream stream = classic();

    static std::istringstream classic() {
        std::istringstream made;
        made.imbue(std::locale::classic());
        return made;
    }

    char peek() {
        const std::string_view blank = " \t\r\n";
        while (at < text.size() && blank.find(text[at]) != blank.npos) ++at;
        return at < text.size() ? text[at] : '\0';
    }

    bool take(char wanted) { return peek() == wanted && ++at; }

    bool word(std::string_view wanted) {
        if (text.substr(at, wanted.size()) != wanted) return false;
        at += wanted.size();
        return true;
    }

    Json value(int depth) {
        Json made;
        const char next = peek();
        if (depth > most_depth) failed = true;
        else if (next == '{' || next == '[') holder(made, depth, ++at && next == '{');
        else if (next == '"') made.kind = Json::Kind::text, made.text = string();
        else if (word("true") || word("false")) made.kind = Json::Kind::boolean;
        else if (!word("null")) made.kind = Json::Kind::number, made.number = number();
        return made;
    }

    void holder(Json& made, int depth, bool object) {
        made.kind = object ? Json::Kind::object : Json::Kind::list;
        const char end = object ? '}' : ']';
        if (take(end)) return;
        do {
            std::string key;
            if (object) {
                key = peek() == '"' ? string() : (failed = true, "");
                failed = failed || !take(':');
            }
            if (failed) return;
            if (object) made.object.emplace_back(std::move(key), value(depth + 1));
            else made.list.push_back(value(depth + 1));
        } while (!failed && take(','));
        failed = failed || !take(end);
    }

    double number() {
        const std::size_t start = at;
        const std::string_view digits = "+-.0123456789eE";
        while (at < text.size() && digits.find(text[at]) != digits.npos) ++at;
        double found = 0;
        stream.clear();
        stream.str(std::string(text.substr(start, at - start)));
        failed = failed || at == start || !(stream >> found) || !stream.eof();
        return found;
    }

    std::string string() {
        std::string made;
        for (++at; at < text.size() && text[at] != '"'; ++at) {
            if (text[at] != '\\') {
                made += text[at];
                continue;
            }
            const char code = ++at < text.size() ? text[at] : '\0';
            const auto place = std::string_view("\"\\/bfnrt").find(code);
            if (place != std::string_view::npos && code) made += "\"\\/\b\f\n\r\t"[place];
            else if (code == 'u') append(made, unit());
            else failed = true;
        }
        failed = failed || at >= text.size();
        ++at;
        return made;
    }

    /// One code point of one or two units of UTF-16; `at` stays at its last digit.
    std::uint32_t unit() {
        const std::uint32_t first = hex();
        if (first < 0xD800 || first > 0xDBFF || text.substr(at + 1, 2) != "\\u") return first;
        const std::size_t before = at;
        at += 2;
        const std::uint32_t second = hex();
        if (second >= 0xDC00 && second <= 0xDFFF)
            return 0x10000 + ((first - 0xD800) << 10) + (second - 0xDC00);
        at = before;
        return first;
    }

    std::uint32_t hex() {
        std::uint32_t found = 0;
        for (int i = 0; i < 4; ++i) {
            const char c = at + 1 < text.size() ? text[++at] : '\0';
            const auto place = std::string_view("0123456789abcdef0123456789ABCDEF").find(c);
            failed = failed || !c || place == std::string_view::npos;
            found = found * 16 + static_cast<std::uint32_t>(place % 16);
        }
        return found;
    }

    static void append(std::string& made, std::uint32_t code) {
        const auto add = [&made](std::uint32_t byte) { made += static_cast<char>(byte); };
        const auto tail = [&](int shift) { add(0x80 | (code >> shift & 0x3F)); };
        if (code < 0x80) add(code);
        else if (code < 0x800) add(0xC0 | code >> 6), tail(0);
        else if (code < 0x10000) add(0xE0 | code >> 12), tail(6), tail(0);
        else add(0xF0 | code >> 18), tail(12), tail(6), tail(0);
    }
};

}  // namespace detail

inline std::optional<Json> Json::read(std::string_view text) {
    detail::Reader reader{text};
    Json found = reader.value(0);
    if (reader.failed || reader.peek() != '\0' || reader.at < text.size()) return std::nullopt;
    return found;
}

inline const Json* curves_of(const Json& curves, std::string_view mesh) {
    const Json* version = curves.get("version");
    std::vector<const Json*> meshes, found;
    if (!detail::is(version, Json::Kind::number) || version->number != 1) return nullptr;
    if (!detail::entries(curves, "meshes", meshes)) return nullptr;
    for (const Json* own : meshes) {
        std::vector<std::string> names;
        const Json* number = own->get("mesh");
        const bool numbered = detail::is(number, Json::Kind::number) && number->number >= 0 &&
                              number->number < 1e9;
        if (const Json* held = own->get("names")) detail::texts(held, names);
        if (numbered) names.push_back(std::to_string(static_cast<std::int64_t>(number->number)));
        if (mesh.empty() || std::find(names.begin(), names.end(), mesh) != names.end())
            found.push_back(own);
    }
    return found.size() == 1 ? found[0] : nullptr;
}

inline std::optional<Description> describe(const Json& extras, std::string& problem) {
    const auto refuse = [&problem](std::string why) {
        problem = std::move(why);
        return std::nullopt;
    };
    Description made;
    const Json* names = extras.get("targetNames");
    if (names && !detail::texts(names, made.targets)) return refuse("targetNames are no names");
    const Json* own = extras.get("elastomorph");
    if (!own || own->kind == Json::Kind::null) return made;
    const Json* version = own->get("version");
    const double number = detail::is(version, Json::Kind::number) ? version->number : 0;
    if (number < 1 || std::fmod(number, 1) != 0) return refuse("no version");
    if (number > detail::newest) return refuse("a newer elastomorph.hpp is needed");
    std::vector<const Json*> morphs, correctives;
    if (!detail::entries(*own, "morphs", morphs)) return refuse("the morphs are no list");
    for (const Json* entry : morphs)
        if (!detail::morph(*entry, number, made.morphs.emplace_back()))
            return refuse("a morph is damaged");
    if (!detail::entries(*own, "correctives", correctives))
        return refuse("the correctives are no list");
    for (const Json* entry : correctives)
        if (!detail::corrective(*entry, number, made.correctives.emplace_back()))
            return refuse("a corrective is damaged");
    return made;
}

}  // namespace elastomorph
