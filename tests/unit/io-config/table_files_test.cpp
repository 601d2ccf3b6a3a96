// alarms.toml and historian.toml: what they say, and each thing that may be wrong with its place.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "core/toml_limits.h"
#include "io-drivers/config/read_alarms.h"
#include "io-drivers/config/read_historian.h"
#include "io-drivers/config/table_file.h"

namespace plc::test {
namespace {

std::vector<alarms::Definition> alarms_of(const std::string& text, std::string& wrong) {
  core::Diagnostics diagnostics;
  auto all = io::read_alarms(text, "alarms.toml", diagnostics);
  std::ostringstream out;
  diagnostics.render(out);
  wrong = out.str();
  return all;
}

TEST(AlarmFile, SaysWhatAnAlarmIs) {
  std::string wrong;
  const auto all = alarms_of(R"(
[[alarm]]
name = "High"
variable = "Level"
above = 95.5
hysteresis = 5
on_delay = "300ms"
off_delay = "1s"
text = "Level is too high"
help = "Drain"
priority = "critical"
class = "process"
group = "stop"
suppress = "Away"
latch = true

[[alarm]]
variable = "EmergencyOk"
when = false
text = "pressed"

[[alarm]]
variable = "Step"
equal = 7
text = "stuck"
)",
                             wrong);
  EXPECT_EQ(wrong, "");
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].name, "High");
  EXPECT_EQ(all[0].comparison, alarms::Comparison::kAbove);
  EXPECT_EQ(all[0].limit, 95.5);
  EXPECT_EQ(all[0].hysteresis, 5);
  EXPECT_EQ(all[0].on_delay_ns, 300'000'000);
  EXPECT_EQ(all[0].off_delay_ns, 1'000'000'000);
  EXPECT_EQ(all[0].priority, alarms::Priority::kCritical);
  EXPECT_EQ(all[0].category + all[0].group + all[0].suppress + all[0].help, "processstopAwayDrain");
  EXPECT_TRUE(all[0].latch);
  EXPECT_EQ(all[1].name, "EmergencyOk") << "the variable, without a name";
  EXPECT_EQ(all[1].comparison, alarms::Comparison::kFalse);
  EXPECT_EQ(all[1].priority, alarms::Priority::kMedium);
  EXPECT_EQ(all[2].comparison, alarms::Comparison::kEqual);
  EXPECT_EQ(all[2].limit, 7);
}

TEST(AlarmFile, IsRefusedAlarmByAlarm) {
  const std::string good = "[[alarm]]\nvariable = \"B\"\ntext = \"good\"\n";
  const struct {
    std::string text, wrong;
    std::size_t left;
  } kCases[] = {
      {"[[alarm]]\nvariable = \"A\"\n", "alarms.toml:1:1: error P7306: [[alarm]] has no \"text\"", 1},
      {"[[alarm]]\nvariable = \"\"\ntext = \"a\"\n", "alarms.toml:2:12: error P7305", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nabov = 3\n",
       "alarms.toml:4:1: error P7303: [[alarm]] has no key \"abov\"\n  help: did you mean \"above\"?", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nabove = \"3\"\n", "alarms.toml:4:9: error P7304", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\non_delay = \"3\"\n", "alarms.toml:4:12: error P7305", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\npriority = \"urgent\"\n", "alarms.toml:4:12: error P7305", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nabove = 3\nbelow = 1\n",
       "alarms.toml:5:9: error P7311: \"above\" and \"below\" are two conditions", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nhysteresis = 3\n", "alarms.toml:4:14: error P7307", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nabove = 1\nhysteresis = -3\n", "alarms.toml:5:14: error P7305", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nabove = true\n",
       "alarms.toml:4:9: error P7304: \"above\" takes a number", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nabove = nan\n", "alarms.toml:4:9: error P7305: \"above\" is nan", 1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nbelow = -inf\n", "alarms.toml:4:9: error P7305: \"below\" is -inf",
       1},
      {"[[alarm]]\nvariable = \"A\"\ntext = \"a\"\nabove = 1\nhysteresis = inf\n", "alarms.toml:5:14: error P7305", 1},
      {"[[alarm]]\nvariable = \"b\"\ntext = \"a\"\n", "error P7309: there are two alarms", 1},
      {"[alarms]\n", "alarms.toml:1:2: error P7303: no table \"alarms\" in this file\n  help: did you mean \"alarm\"?",
       1},
      {"alarm = 3\n", "alarms.toml:1:1: error P7304: \"alarm\" is not a list of tables", 0},
      {"[[alarm]\n", "error P7301", 0},
      {"\xe4\n", "error P7301", 0},
  };
  for (const auto& one : kCases) {
    std::string wrong;
    const bool whole = one.left == 1;
    const auto all = alarms_of(whole ? one.text + good : one.text, wrong);
    EXPECT_NE(wrong.find(one.wrong), std::string::npos) << one.text << "\ngives\n" << wrong;
    EXPECT_EQ(all.size(), one.left) << one.text;
  }
}

TEST(AlarmFile, HasItsKeysInTheGuide) {
  std::ifstream in(PLC_SOURCE_ROOT "/docs/guides/alarms.md");
  const std::string guide{std::istreambuf_iterator<char>(in), {}};
  for (const io::KeyInfo& key : io::alarm_keys())
    EXPECT_NE(guide.find("`" + std::string(key.name) + "`"), std::string::npos) << key.name;
}

TEST(TableFile, IsReadWhereThereIsOne) {
  const std::string folder = testing::TempDir() + "table-file-" + std::to_string(::getpid());
  std::filesystem::create_directories(folder + "/folder.toml");
  std::ofstream(folder + "/good.toml") << "[historian]\n";
  std::ofstream(folder + "/large.toml") << std::string(core::kMaxTomlBytes + 1, '#');
  ASSERT_EQ(::mkfifo((folder + "/pipe.toml").c_str(), 0600), 0);
  const auto found = [&](const char* name, std::optional<std::string>& text) {
    core::Diagnostics diagnostics;
    text = io::table_file_text(folder + name, diagnostics);
    return diagnostics.all().empty() ? std::string() : std::string(core::info(diagnostics.all().front().code).name);
  };
  std::optional<std::string> text;
  EXPECT_EQ(found("/good.toml", text), "");
  EXPECT_EQ(text, "[historian]\n");
  EXPECT_EQ(found("/none.toml", text), "");
  EXPECT_FALSE(text);
  EXPECT_EQ(found("/folder.toml", text), "P7001");
  EXPECT_EQ(found("/pipe.toml", text), "P7001");
  EXPECT_EQ(found("/large.toml", text), "P7302");
  EXPECT_FALSE(text);
  std::filesystem::remove_all(folder);
}

TEST(HistorianFile, SaysWhatIsKept) {
  core::Diagnostics diagnostics;
  const auto settings = io::read_historian(
      "[historian]\ntags = [\"Level\", \"Valve*\"]\ninterval = \"1s\"\ndays = 7\nsize = 100\nfolder = \"h\"\n",
      "historian.toml", diagnostics);
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->tags, (std::vector<std::string>{"Level", "Valve*"}));
  EXPECT_EQ(settings->interval_ns, 1'000'000'000);
  EXPECT_EQ(settings->days, 7u);
  EXPECT_EQ(settings->most_bytes, 100'000'000u);
  EXPECT_EQ(settings->folder, "h");
  const auto plain = io::read_historian("[historian]\ntags = [\"Level\"]\n", "historian.toml", diagnostics);
  EXPECT_EQ(plain->interval_ns, 100'000'000);
  EXPECT_EQ(plain->days, 30u);
  EXPECT_EQ(diagnostics.all().size(), 0u);
  for (const char* const text : {"[historian]\n", "[historian]\ntags = \"Level\"\n", "[historian]\ntags = [3]\n",
                                 "[historian]\ntags = [\"A\"]\ninterval = \"1ms\"\n", "[[historian]]\ntags = [\"A\"]\n",
                                 "[historian]\ntags = [\"A\"]\ndays = 0\n"}) {
    core::Diagnostics found;
    EXPECT_FALSE(io::read_historian(text, "historian.toml", found)) << text;
    EXPECT_EQ(found.error_count(), 1u) << text;
  }
}

}  // namespace
}  // namespace plc::test
