#include <algorithm>
#include <optional>
#include <sstream>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "config/yaml/document.hpp"
#include "conversion/limits.hpp"

namespace copepod::coupler {
namespace {

/// Aliases make a small file into a huge tree; no honest case comes near this.
constexpr std::size_t most_values = 2'000'000;
/// An anchor around its own alias is a tree without end.
constexpr int most_levels = 64;

/// Of YAML 1.1: `<<: *anchor` adds the entries of another mapping that this one does not have.
constexpr const char* merge_key = "<<";

class Conversion {
 public:
  explicit Conversion(const Origin& start) : start_(start) {}

  Value convert(const YAML::Node& node) {
    if (++values_ > most_values) {
      throw CaseInvalid(
          origin(node.Mark()),
          "the case has more than 2000000 values (aliases multiply them). Write fewer bodies or no nested aliases.");
    }
    if (level_ == most_levels) {
      throw CaseInvalid(origin(node.Mark()),
                        "the case is nested more than 64 levels deep (an alias inside its own anchor has no end). Take "
                        "the alias out.");
    }
    ++level_;
    Value value;
    value.origin = origin(node.Mark());
    switch (node.Type()) {
      case YAML::NodeType::Scalar:
        value.kind = Value::Kind::scalar;
        value.text = text(node);
        break;
      case YAML::NodeType::Sequence:
        value.kind = Value::Kind::sequence;
        for (const YAML::Node& item : node) value.items.push_back(convert(item));
        break;
      case YAML::NodeType::Map:
        value.kind = Value::Kind::mapping;
        convert_entries(node, value);
        break;
      case YAML::NodeType::Null:
      case YAML::NodeType::Undefined:
        break;
    }
    --level_;
    return value;
  }

  [[nodiscard]] Origin origin(const YAML::Mark& mark) const {
    return {start_.source, start_.line > 0 ? start_.line + mark.line : 0};
  }

 private:
  /// Names travel in messages and JSON, which take nothing else.
  const std::string& text(const YAML::Node& node) {
    if (conversion::as_utf8(node.Scalar(), node.Scalar().size()) == node.Scalar()) return node.Scalar();
    throw CaseInvalid(
        origin(node.Mark()),
        "a word here is not UTF-8 text (the file was saved in another encoding, or is not text). Save it as UTF-8.");
  }

  void convert_entries(const YAML::Node& node, Value& value) {
    std::set<std::string> seen;
    for (const auto& pair : node) {
      const Origin key_origin = origin(pair.first.Mark());
      if (!pair.first.IsScalar()) {
        throw CaseInvalid(key_origin, "a key is a list or a mapping (keys are plain words). Write `key: value`.");
      }
      const std::string& key = text(pair.first);
      if (!seen.insert(key).second) {
        throw CaseInvalid(key_origin,
                          "key '" + key + "' appears twice in one section (only one can count). Remove one of them.");
      }
      if (key != merge_key) value.entries.push_back({key, key_origin, convert(pair.second)});
    }
    if (const YAML::Node merged = node[merge_key]) merge(convert(merged), value);
  }

  /// Adds the entries of a mapping, or of each of a list of mappings, that `value` does not have yet.
  static void merge(Value merged, Value& value) {
    if (merged.kind == Value::Kind::sequence) {
      for (Value& item : merged.items) merge(std::move(item), value);
      return;
    }
    if (merged.kind != Value::Kind::mapping) {
      throw CaseInvalid(merged.origin,
                        "`<<` does not merge a mapping (it adds the keys of another section). Write `<<: *anchor`, or "
                        "`<<: [*one, *two]`.");
    }
    for (Value::Entry& entry : merged.entries)
      if (value.find(entry.key) == nullptr) value.entries.push_back(std::move(entry));
  }

  const Origin& start_;
  std::size_t values_ = 0;
  int level_ = 0;
};

/// Where a second document begins, which YAML::Load does not read; YAML::LoadAll may never end.
std::optional<YAML::Mark> second_document(const std::string& text) {
  struct Documents final : YAML::EventHandler {
    std::vector<YAML::Mark> starts;
    void OnDocumentStart(const YAML::Mark& mark) override { starts.push_back(mark); }
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
    void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
    void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
    void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
    void OnSequenceEnd() override {}
    void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {}
    void OnMapEnd() override {}
  } documents;
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  while (documents.starts.size() < 2 && parser.HandleNextDocument(documents)) {
  }
  return documents.starts.size() < 2 ? std::nullopt : std::optional(documents.starts[1]);
}

/// The emitter leaves some control characters bare, a lone carriage return for one, which no reader
/// gives back.
void emit_text(YAML::Emitter& out, const std::string& text) {
  const bool is_plain = std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7F; });
  if (!is_plain) out << YAML::DoubleQuoted;
  out << text;
}

void emit(YAML::Emitter& out, const nlohmann::ordered_json& value) {
  if (value.is_object()) {
    out << YAML::Block << YAML::BeginMap;
    for (const auto& [key, item] : value.items()) {
      out << YAML::Key;
      emit_text(out, key);
      out << YAML::Value;
      emit(out, item);
    }
    out << YAML::EndMap;
  } else if (value.is_array()) {
    const bool is_plain = std::ranges::none_of(value, [](const auto& item) { return item.is_structured(); });
    out << (is_plain ? YAML::Flow : YAML::Block) << YAML::BeginSeq;
    for (const auto& item : value) emit(out, item);
    out << YAML::EndSeq;
  } else if (value.is_number_float()) {
    out << shortest_text(value);
  } else if (value.is_string()) {
    emit_text(out, value);
  } else {
    out << value.dump();
  }
}

std::string line_of(const std::string& text, const YAML::Mark& mark) {
  std::istringstream stream(text);
  std::string line;
  for (int number = 0; number <= mark.line; ++number) std::getline(stream, line);
  return line;
}

/// What is wrong in a line that ends YAML's parser.
std::string problem_with(const std::string& line, const YAML::Exception& error) {
  if (line.substr(0, line.find_first_not_of(" \t")).find('\t') != std::string::npos)
    return "the line is indented with a tab (YAML takes spaces only). Replace the tab with spaces.";
  const std::size_t star = line.find('*', std::max(error.mark.column, 0));
  if (error.msg.starts_with(YAML::ErrorMsg::UNKNOWN_ANCHOR) && star != std::string::npos) {
    const std::string alias = line.substr(star, line.find_first_of(" ,]}", star) - star);
    return alias + " stands for nothing (no &" + alias.substr(1) + " comes before it). Write &" + alias.substr(1) +
           " at what is meant, above this line.";
  }
  return "this is not valid YAML (" + error.msg + "). Look at indentation, brackets and colons here.";
}

}  // namespace

Value parse_yaml(const std::string& text, const Origin& start) {
  Conversion conversion(start);
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF") || text.find('\0') != std::string::npos)
    throw CaseInvalid(Origin{start.source, 1},
                      "this is not UTF-8 text (saved as UTF-16, or not text). Save it as UTF-8.");
  try {
    if (const auto second = second_document(text))
      throw CaseInvalid(conversion.origin(*second),
                        "a second document begins here (a case is one document; `---` separates several). Put it in a "
                        "file of its own.");
    return conversion.convert(YAML::Load(text));
  } catch (const YAML::Exception& error) {
    throw CaseInvalid(conversion.origin(error.mark), problem_with(line_of(text, error.mark), error));
  }
}

std::string to_yaml(const nlohmann::ordered_json& value) {
  YAML::Emitter out;
  emit(out, value);
  return std::string(out.c_str()) + "\n";
}

}  // namespace copepod::coupler
