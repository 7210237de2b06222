// Answers a file of the conformance kit: `conform ../conformance/vectors/folds.json`.
#include <cstdio>
#include <fstream>
#include <iterator>

#include "elastomorph.hpp"

using elastomorph::Bender;
using elastomorph::Json;

template <class Real>
void print(const char* name, const Bender& bender, const Json& sliders) {
    std::vector<Real> values, weights(bender.targets().size(), Real(-1));
    for (const auto& slider : bender.sliders()) {
        const Json* value = sliders.get(slider);
        values.push_back(value ? Real(value->number) : std::numeric_limits<Real>::quiet_NaN());
    }
    bender.weights(values.data(), weights.data());
    std::printf("\"%s\": [", name);
    for (std::size_t i = 0; i < weights.size(); ++i)
        std::printf("%s%.17g", i ? ", " : "", static_cast<double>(weights[i]));
    std::printf("]");
}

std::optional<Bender> read(const Json& holder, std::string& problem) {
    const Json* curves = holder.get("curves");
    const Json* extras =
        curves ? elastomorph::curves_of(*curves, holder.get("mesh")->text) : holder.get("extras");
    const auto described = elastomorph::describe(*extras, problem);
    return described ? Bender::from(*described, problem) : std::nullopt;
}

int main(int, char** words) {
    std::ifstream file(words[1], std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const auto content = Json::read(text);
    if (!content) return 1;
    std::string problem;
    const char* between = "[";
    if (content->kind == Json::Kind::list) {
        for (const Json& entry : content->list) {
            if (read(entry, problem)) std::printf("%snull", between);
            else std::printf("%s\"refused\"", between);
            between = ", ";
        }
    } else {
        const auto bender = read(*content, problem);
        if (!bender) return std::fprintf(stderr, "%s\n", problem.c_str()), 1;
        for (const Json& pose : content->get("poses")->list) {
            std::printf("%s{", between);
            print<double>("double", *bender, *pose.get("sliders"));
            std::printf(", ");
            print<float>("single", *bender, *pose.get("sliders"));
            std::printf("}");
            between = ", ";
        }
    }
    std::printf("]\n");
}
