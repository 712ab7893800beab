// Main of a fuzz target in builds without libFuzzer: runs it on every input of the given corpora, and on every
// input with one byte changed, left out or cut off. A corpus has a line `name bytes` for each, in hexadecimal digits.

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size);

namespace {

using Input = std::vector<std::uint8_t>;

constexpr std::size_t kPlaces = 24;  ///< bytes per input that are tampered with

Input input_of(const std::string& line) {
  Input input;
  for (std::size_t place = line.find(' ') + 1; place < line.size(); place += 2)
    input.push_back(static_cast<std::uint8_t>(std::stoul(line.substr(place, 2), nullptr, 16)));
  return input;
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
  int inputs = 0;
  int runs = 0;
  for (int i = 1; i < argc; ++i) {
    std::ifstream corpus(argv[i]);
    for (std::string line; std::getline(corpus, line); ++inputs) {
      const Input input = input_of(line);
      runs += run(input) + run_tampered(input);
    }
  }
  std::printf("%d inputs, %d runs\n", inputs, runs);
  return inputs == 0 ? 1 : 0;
}
