#include "config/yaml/document.hpp"

#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

const char* const text = R"(case: x
bodies:
  - name: one
    position_m: [1, 2, 3]
  - name: two
    position_m: [4, 5, 6]
run:
  steps: 10
)";

std::string text_at(const Document& document, const std::string& key) {
  const Value* value = document.root().find(key);
  return value == nullptr ? "" : value->text;
}

TEST(Document, KnowsTheLineOfEveryKeyPath) {
  const Document document = Document::parse(text, "x.yaml", {});
  EXPECT_EQ(document.locate("case").line, 1);
  EXPECT_EQ(document.locate("bodies").line, 2);
  EXPECT_EQ(document.locate("bodies.1").line, 5);
  EXPECT_EQ(document.locate("bodies.1.position_m.2").line, 6);
  EXPECT_EQ(document.locate("bodies.two.position_m").line, 6);
  EXPECT_EQ(document.locate("run.steps").line, 8);
  EXPECT_EQ(document.locate("run.nothing").line, 7);
  EXPECT_EQ(to_string(document.locate("run.steps")), "x.yaml:8");
}

TEST(Document, AppliesOverridesByPositionAndByName) {
  const Document document = Document::parse(
      text, "x.yaml", {"bodies.0.name=uno", "bodies.two.position_m=[7, 8, 9]", "new.section.key=5", "case=y=z"});
  EXPECT_EQ(document.root().find("bodies")->items[0].find("name")->text, "uno");
  EXPECT_EQ(document.root().find("bodies")->items[1].find("position_m")->items[2].text, "9");
  EXPECT_EQ(document.root().find("new")->find("section")->find("key")->text, "5");
  EXPECT_EQ(text_at(document, "case"), "y=z");
  EXPECT_EQ(to_string(document.locate("bodies.0.name")), "--set bodies.0.name=uno");
}

TEST(Document, RejectsOverridesThatLeadNowhere) {
  EXPECT_THROW(Document::parse(text, "x.yaml", {"bodies.5.name=x"}), CaseInvalid);
  EXPECT_THROW(Document::parse(text, "x.yaml", {"bodies.three.name=x"}), CaseInvalid);
  EXPECT_THROW(Document::parse(text, "x.yaml", {"case.deeper=x"}), CaseInvalid);
  EXPECT_THROW(Document::parse(text, "x.yaml", {"no assignment"}), CaseInvalid);
  EXPECT_THROW(Document::parse(text, "x.yaml", {"=5"}), CaseInvalid);
  EXPECT_THROW(Document::parse(text, "x.yaml", {"case=[1"}), CaseInvalid);
}

TEST(Document, AppliesTheChosenParameterSetBelowTheCommandLine) {
  const std::string sets =
      std::string(text) + "parameter_set: a\nparameter_sets:\n  a: {run.steps: 20}\n  b: {run.steps: 30}\n";
  const auto steps = [&](const std::vector<std::string>& overrides) {
    return Document::parse(sets, "x.yaml", overrides).root().find("run")->find("steps")->text;
  };
  EXPECT_EQ(steps({}), "20");
  EXPECT_EQ(steps({"parameter_set=b"}), "30");
  EXPECT_EQ(steps({"run.steps=40"}), "40");
  EXPECT_EQ(steps({"run.steps=40", "parameter_set=b"}), "40");
  EXPECT_THROW(steps({"parameter_set=c"}), CaseInvalid);
}

TEST(Document, RejectsAChoiceOfParameterSetWhereThereIsNone) {
  EXPECT_THROW(Document::parse(text, "x.yaml", {"parameter_set=a"}), CaseInvalid);
  EXPECT_NO_THROW(Document::parse(std::string(text) + "parameter_set: label\n", "x.yaml", {}));
}

TEST(Document, RejectsWhatIsNoMapping) {
  EXPECT_THROW(Document::parse("- a\n- b\n", "x.yaml", {}), CaseInvalid);
  EXPECT_THROW(Document::parse("", "x.yaml", {}), CaseInvalid);
  EXPECT_THROW(Document::parse("? [a, b]\n: c\n", "x.yaml", {}), CaseInvalid);
  EXPECT_THROW(Document::load("/nonexistent.yaml", {}), CaseInvalid);
  EXPECT_THROW(Document::load("/tmp", {}), CaseInvalid);
}

TEST(Document, RejectsAPositionThatIsTheNameOfAnotherItem) {
  const std::string text = "bodies: [{name: '1', x: 1}, {name: b, x: 2}, {name: '2', x: 3}]\n";
  EXPECT_THROW(Document::parse(text, "case.yaml", {"bodies.1.x=4"}), CaseInvalid);
  EXPECT_NO_THROW(Document::parse(text, "case.yaml", {"bodies.2.x=4", "bodies.0.x=4", "bodies.b.x=4"}));
}

TEST(YamlText, RefusesASecondDocumentAndOtherEncodings) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"case: a\n---\ncase: b\n", "case.yaml:2: error: a second document begins here"},
      {std::string("\xFF\xFE"
                   "c\0:\0",
                   6),
       "case.yaml:1: error: this is not UTF-8 text"}};
  for (const auto& [text, message] : cases) {
    try {
      Document::parse(text, "case.yaml", {});
      ADD_FAILURE() << text;
    } catch (const CaseInvalid& invalid) {
      EXPECT_NE(std::string(invalid.what()).find(message), std::string::npos) << invalid.what();
    }
  }
  EXPECT_NO_THROW(Document::parse("---\ncase: a\n", "case.yaml", {}));
  EXPECT_NO_THROW(
      Document::parse("\xEF\xBB\xBF"
                      "case: a\n",
                      "case.yaml", {}));
}

TEST(YamlText, MergesTheKeysOfOtherSections) {
  const std::string anchors = "case: x\nbead: &bead {radius_m: 1, mass_kg: 2}\nheavy: &heavy {mass_kg: 3, name: h}\n";
  const Document document = Document::parse(anchors +
                                                "one: {mass_kg: 4, <<: *bead}\n"
                                                "two:\n  <<: [*heavy, *bead]\n  name: t\n",
                                            "x.yaml", {});
  const auto text_of = [&](const char* section, const char* key) {
    const Value* value = document.root().find(section)->find(key);
    return value == nullptr ? "" : value->text;
  };
  EXPECT_EQ(text_of("one", "mass_kg"), "4");
  EXPECT_EQ(text_of("one", "radius_m"), "1");
  EXPECT_EQ(document.root().find("one")->entries.size(), 2U);
  EXPECT_EQ(text_of("two", "name"), "t");
  EXPECT_EQ(text_of("two", "mass_kg"), "3");
  EXPECT_EQ(text_of("two", "radius_m"), "1");
  EXPECT_EQ(document.locate("two.radius_m").line, 2);
  EXPECT_EQ(document.root().find("one")->find("<<"), nullptr);
}

TEST(YamlText, RefusesToMergeWhatIsNoMapping) {
  EXPECT_THROW(parse_yaml("a: {<<: 5}", {"x.yaml", 1}), CaseInvalid);
  EXPECT_THROW(parse_yaml("b: &b [1]\na: {<<: *b}", {"x.yaml", 1}), CaseInvalid);
}

TEST(Problems, WarnsOnceOfEachKindAndCountsTheOthers) {
  const Document document = Document::parse(text, "x.yaml", {});
  Problems problems(document);
  problems.warning("bodies.0", "body 'one' is 1.5e-6 m wide (too wide). Cut it.");
  problems.warning("run.steps", "run.steps is 10 (few). Use more.");
  problems.warning("bodies.1", "body 'two' is 3 m wide (too wide). Cut it.");
  problems.warning("bodies.1", "body 'two' is 4 m wide (too wide). Cut it.");
  const std::vector<std::string> lines = problems.warnings();
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0], "x.yaml:3: warning: body 'one' is 1.5e-6 m wide (too wide). Cut it. (2 more of this kind.)");
  EXPECT_EQ(lines[1], "x.yaml:8: warning: run.steps is 10 (few). Use more.");
}

TEST(YamlText, StopsAliasesThatMultiply) {
  std::string bomb = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 9; ++i) {
    const std::string name = std::to_string(i);
    const std::string before = std::to_string(i - 1);
    bomb.append("a").append(name).append(": &a").append(name).append(" [x");
    for (int copy = 0; copy < 10; ++copy) bomb.append(", *a").append(before);
    bomb += "]\n";
  }
  EXPECT_THROW(Document::parse(bomb, "bomb.yaml", {}), CaseInvalid);
}

TEST(YamlText, StopsAnAliasInsideItsOwnAnchor) {
  EXPECT_THROW(Document::parse("a: &x {b: *x}\n", "endless.yaml", {}), CaseInvalid);
}

TEST(YamlText, WritesWhatItReads) {
  const Value value = parse_yaml("a: {b: [1, 2], c: ~, d: [{e: 'x: y'}]}\n", {"x", 1});
  const std::string once = to_yaml(to_json(value));
  EXPECT_EQ(to_yaml(to_json(parse_yaml(once, {"x", 1}))), once);
  EXPECT_EQ(to_json(value).dump(), R"({"a":{"b":["1","2"],"c":null,"d":[{"e":"x: y"}]}})");
}

TEST(YamlText, GivesControlCharactersBack) {
  Value list = parse_yaml("[a]", {"x", 1});
  for (const char* word : {"\r", "a\rb", "\t", "\n", "\x07", "\x7f"}) {
    list.items[0].text = word;
    EXPECT_EQ(parse_yaml(to_yaml(to_json(list)), {"x", 1}).items[0].text, word);
  }
}

}  // namespace
}  // namespace copepod::coupler
