// Reads extras cut short and changed everywhere, then counts what a frame allocates.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <new>

#include "elastomorph.hpp"

static std::size_t allocations = 0;

[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations;
    if (void* found = std::malloc(size ? size : 1)) return found;
    std::abort();
}
[[gnu::noinline]] void operator delete(void* at) noexcept { std::free(at); }
[[gnu::noinline]] void operator delete(void* at, std::size_t) noexcept { std::free(at); }

using elastomorph::Bender;

static std::size_t posed = 0;

static void pose(const std::optional<Bender>& bender) {
    if (!bender) return;
    std::vector<float> values(bender->sliders().size(), 0.3F), weights(bender->targets().size());
    const std::size_t before = allocations;
    bender->weights(values.data(), weights.data());
    if (allocations != before) std::abort();
    ++posed;
}

int main(int, char** words) {
    std::ifstream file(words[1], std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    std::string problem;
    pose(Bender::from_json(text, problem));
    if (posed != 1) return 1;
    for (std::size_t end = 0; end < text.size(); ++end)
        pose(Bender::from_json(text.substr(0, end), problem));
    if (posed != 1) return 2; // none of the shorter ones is complete
    for (std::size_t at = 0; at < text.size(); ++at)
        for (const char other : {'"', '\\', '{', ']', ',', '9', '\0', 'u'}) {
            std::string changed = text;
            changed[at] = other;
            pose(Bender::from_json(changed, problem));
        }
    for (const char* deep : {"[", "{\"a\":"}) {
        std::string nested;
        for (int depth = 0; depth < 1000000; ++depth) nested += deep;
        pose(Bender::from_json(nested, problem));
    }
    std::printf("%zu\n", posed);
}
