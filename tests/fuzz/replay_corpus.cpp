// Main of a fuzz target in builds without libFuzzer: runs it on every file of the given folders, and on every
// file with one byte changed, left out or cut off.

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace {

using Input = std::vector<std::uint8_t>;

constexpr std::size_t kPlaces = 24;  ///< bytes per file that are tampered with

Input content_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

int run(const Input& input) {
  LLVMFuzzerTestOneInput(input.data(), input.size());
  return 1;
}

int run_tampered(const Input& input) {
  int runs = 0;
  const std::size_t stride = input.size() / kPlaces + 1;
  for (std::size_t place = 0; place < input.size(); place += stride) {
    Input changed = input;
    changed[place] ^= 0x55U;
    runs += run(changed);
    changed.erase(changed.begin() + static_cast<std::ptrdiff_t>(place));
    runs += run(changed);
    changed.assign(input.begin(), input.begin() + static_cast<std::ptrdiff_t>(place));
    runs += run(changed);
  }
  return runs;
}

}  // namespace

int main(int argc, char** argv) {
  int files = 0;
  int runs = 0;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::directory_iterator(argv[i])) {
      const Input input = content_of(entry.path());
      runs += run(input) + run_tampered(input);
      ++files;
    }
  }
  std::printf("%d files, %d runs\n", files, runs);
  return files == 0 ? 1 : 0;
}
