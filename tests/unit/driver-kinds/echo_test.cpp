// A kind of driver that this folder alone knows: its row is enough for plc.toml, its mistakes, `plc config init`, the
// reference page, bind() and Machine.
#include <gtest/gtest.h>

#include <deque>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "io-drivers/config/driver_type.h"
#include "io-drivers/config/findings.h"
#include "io-drivers/config/template.h"
#include "io-drivers/gpio/gpio_driver.h"
#include "io-drivers/machine/machine.h"
#include "io-drivers/modbus-client/modbus_driver.h"
#include "io-drivers/simulated/simulated_device.h"
#include "runtime/access.h"
#include "runtime/memory/global_ports.h"
#include "tests/support/image_builder.h"

namespace plc::io {
namespace {

using core::TypeId;
using test::ImageBuilder;

// ---- The kind: an INT that is written to a slot is heard by the inputs that listen to it, some cycles later.

enum class Answer : std::uint8_t { kSame, kNegated };

constexpr KeyInfo kDriverKeys[] = {
    {"place", key::text(), key::required("\"cave\""), "Where it echoes; nothing does in the void."},
    {"delay", key::integer(0, 9), key::otherwise("1"), "Cycles until the echo."},
    {"answer", key::choice("same|negated"), key::otherwise("\"same\""), "What comes back."},
    {"rest", key::duration("0s", "1s"), key::otherwise("\"20ms\""), "Not used."},
    {"loud", key::boolean(), key::otherwise("true"), "Not used."},
    {"guests", key::texts(), key::otherwise("[]"), "Not used."},
};
constexpr KeyInfo kChannelKeys[] = {
    {"slot", key::integer(0, 99), key::required("7"), "Slot that is written.", kOutputsOnly},
    {"hears", key::integer(0, 99), key::required("7"), "Slot that is heard.", kInputsOnly},
    {"gain", key::integer(1, 9), key::otherwise("1"), "Factor.", kOutputsOnly},
};

int made = 0;

class Echo final : public Driver {
 public:
  Echo(const BoundDriver& bound, runtime::Resource& resource) : config_(*bound.config), bound_(bound) {
    inputs_.emplace(resource.globals(), claimed_fields(bound));
    reader_.emplace(resource.globals());
    ++made;
  }
  [[nodiscard]] std::string_view name() const override { return config_.name; }
  [[nodiscard]] Timing timing() const override { return Timing::kOffline; }
  [[nodiscard]] std::uint32_t task() const override { return bound_.task; }
  [[nodiscard]] bool has_outputs() const override { return false; }
  std::optional<core::Problem> check() override {
    if (config_.values.text("place") != "void") return std::nullopt;
    return core::Problem{core::Code::P7401, "the void does not answer", "go to a cave"};
  }
  std::optional<core::Problem> open() override { return std::nullopt; }
  std::vector<io::Sentence> service(core::TimeNs) override { return {}; }
  [[nodiscard]] DriverStatus status() const override { return {.connected = true, .problem = {}}; }
  [[nodiscard]] std::vector<InputStatus> inputs(core::TimeNs) const override { return {}; }
  bool drive_safe() noexcept override { return true; }
  void close() noexcept override {}
  void safe_state() noexcept override {}

  void before_scan(const runtime::ReleaseContext&) noexcept override {
    if (under_way_.size() <= std::size_t(config_.values.number("delay"))) return;
    for (const BoundChannel& input : bound_.inputs) {
      const std::int16_t value = under_way_.front()[input.config->values.number("hears")];
      inputs_->set(input.offset, input.type, reinterpret_cast<const std::byte*>(&value));
    }
    inputs_->publish();
    under_way_.pop_front();
  }
  void after_scan(const runtime::ReleaseContext&) noexcept override {
    const int sign = config_.values.choice<Answer>("answer") == Answer::kNegated ? -1 : 1;
    auto& slots = under_way_.emplace_back();
    reader_->take();
    for (const BoundChannel& output : bound_.outputs) {
      std::int16_t value = 0;
      reader_->read(output.offset, 2, reinterpret_cast<std::byte*>(&value));
      const auto& values = output.config->values;
      slots[values.number("slot")] = static_cast<std::int16_t>(sign * value * values.number("gain"));
    }
  }

 private:
  const DriverConfig& config_;
  BoundDriver bound_;
  std::optional<runtime::GlobalInputs> inputs_;
  std::optional<runtime::GlobalReader> reader_;
  std::deque<std::map<std::int64_t, std::int16_t>> under_way_;
};

void check(const DriverConfig& driver, std::span<const ChannelConfig* const> channels, Findings& findings) {
  if (driver.values.number("delay") != 0 || channels.empty()) return;
  findings.add(core::Code::P7311, driver.values.place("delay", driver.at), "an echo is never at once");
}
std::string channel_name(const DriverConfig& driver, const ChannelConfig& channel) {
  if (!channel.values.has("slot")) return {};
  return "slot " + channel.values.text("slot") + " of " + driver.values.text("place");
}
std::string_view refuses(const KeyValues&, const bytecode::ImageType& type) {
  return type.kind == bytecode::TypeKind::kScalar && type.elementary == TypeId::kInt ? "" : "an echo carries an INT";
}
std::optional<std::string> example_channel(const bytecode::ImageType&, std::uint32_t& next) {
  if (next++ > 0) return std::nullopt;
  return "slot = 7";
}
std::unique_ptr<Driver> make(const BoundDriver& bound, const Configuration&, runtime::Resource& resource) {
  return std::make_unique<Echo>(bound, resource);
}

constexpr DriverType kEchoType = {
    .name = "echo",
    .summary = "what is written is heard again.",
    .example = "cave",
    .driver_keys = kDriverKeys,
    .channel_keys = kChannelKeys,
    .device_key = "place",
    .check = check,
    .channel_name = channel_name,
    .refuses = refuses,
    .example_channel = example_channel,
    .make = make,
};

// ---- What everybody else makes of it.

/// Three that PICARD comes with, by name, so that a new one changes nothing here; and this one.
DriverTypes types() {
  static constexpr const DriverType* kAll[] = {&kGpioType, &kSimulatedType, &modbus_client::kModbusType, &kEchoType};
  return kAll;
}

/// Out := In + 1, every millisecond.
std::unique_ptr<runtime::Resource> counter() {
  ImageBuilder b;
  const auto in = b.global("In", b.type(TypeId::kInt), {}, {.input = true, .address = "%IW0"});
  const auto out = b.global("Out", b.type(TypeId::kInt), {}, {.address = "%QW0"});
  b.global("Level", b.type(TypeId::kReal), {}, {.address = "%QD1"});
  const auto one = b.constant<std::int16_t>(TypeId::kInt, 1);
  auto main = b.pou("Main", bytecode::PouKind::kProgram);
  main.op(bytecode::Opcode::kAdd16, {out, in, one});
  b.task("T", 1'000'000, {main.finish()});
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(b.build(), diagnostics);
  for (const core::Diagnostic& d : diagnostics.all()) ADD_FAILURE() << diagnostics.render_one(d);
  return std::move(runtime::Resource::load(std::move(verified.value())).value());
}

struct Read {
  core::Diagnostics diagnostics;
  std::optional<Configuration> configuration;
  explicit Read(std::string_view text) { configuration = read_configuration(text, "plc.toml", types(), diagnostics); }
  [[nodiscard]] std::string problems() const {
    std::string all;
    for (const core::Diagnostic& d : diagnostics.all()) all += diagnostics.render_one(d) + '\n';
    return all;
  }
};

const std::string kCave = "[modbus]\nlisten = \"off\"\n[drivers.cave]\nkind = \"echo\"\nplace = \"cave\"\n";
const std::string kChannels =
    "[inputs]\n\"%IW0\" = { driver = \"cave\", hears = 3 }\n[outputs]\n\"%QW0\" = { driver = \"cave\", slot = 3 }\n";

TEST(ThirdKind, ItsValuesHaveTheTypesOfTheirRows) {
  const Read read(kCave + "delay = 2\nanswer = \"negated\"\nrest = \"1.5ms\"\nloud = false\nguests = [\"a\", \"b\"]\n" +
                  kChannels + "[drivers.hall]\nkind = \"echo\"\nplace = \"hall\"\n");
  ASSERT_TRUE(read.configuration.has_value()) << read.problems();
  const KeyValues& cave = read.configuration->drivers[0].values;
  EXPECT_EQ(read.configuration->drivers[0].type, &kEchoType);
  EXPECT_EQ(cave.text("place"), "cave");
  EXPECT_EQ(cave.place("place", {}).line, 5u);
  EXPECT_EQ(cave.place("place", {}).column, 9u);
  EXPECT_EQ(cave.number("delay"), 2);
  EXPECT_EQ(cave.choice<Answer>("answer"), Answer::kNegated);
  EXPECT_EQ(cave.number("rest"), 1'500'000);
  EXPECT_FALSE(cave.flag("loud"));
  ASSERT_EQ(cave.list("guests").size(), 2u);
  EXPECT_EQ(cave.list("guests")[1].text, "b");
  EXPECT_EQ(cave.list("guests")[1].at.column, 16u);
  EXPECT_EQ(read.configuration->inputs[0].values.number("hears"), 3);
  const KeyValues& hall = read.configuration->drivers[1].values;
  EXPECT_FALSE(hall.has("delay"));
  EXPECT_EQ(hall.number("delay"), 1);
  EXPECT_EQ(hall.choice<Answer>("answer"), Answer::kSame);
  EXPECT_EQ(hall.number("rest"), 20'000'000);
  EXPECT_TRUE(hall.flag("loud"));
  EXPECT_TRUE(hall.list("guests").empty());
  EXPECT_THROW(static_cast<void>(hall.number("delays")), std::logic_error);
}

TEST(ThirdKind, WrongKeysAreReportedAtTheirPlaces) {
  const std::string start = "[drivers.cave]\nkind = \"echo\"\nplace = \"cave\"\n";
  const std::string input = start + "[inputs]\nX = { driver = \"cave\", hears = 1";
  const std::pair<std::string, std::string> rows[] = {
      {"[drivers.a]\nkind = \"ecco\"\n",
       "2:8: error P7305: \"kind\" is \"ecco\"; it takes one of \"gpio\", \"simulated\", \"modbus\", \"echo\"\n"
       "  help: did you mean \"echo\"?\n"},
      {"[drivers.a]\nkind = \"echo\"\n",
       "1:10: error P7306: driver \"a\" has no \"place\"\n  help: add place = \"cave\"\n"},
      {start + "delay = 10\n", "4:9: error P7305: \"delay\" is \"10\"; it takes a whole number from 0 to 9\n"},
      {start + "delay = \"1\"\n", "4:9: error P7304: \"delay\" is a text; it takes a whole number from 0 to 9\n"},
      {start + "guests = [1]\n", "4:11: error P7304: \"guests\" has a whole number in it; it takes a list of texts\n"},
      {start + "delai = 1\n",
       "4:1: error P7303: driver \"cave\" has no key \"delai\"\n  help: did you mean \"delay\"?\n"},
      {start + "chip = \"c\"\n",
       "4:1: error P7307: \"chip\" does not belong to driver \"cave\"\n  help: gpio only: take it out\n"},
      {"[drivers.a]\nkind = \"simulated\"\ndelay = 1\n",
       "3:1: error P7307: \"delay\" does not belong to driver \"a\"\n  help: echo only: take it out\n"},
      {input + ", slot = 1 }\n",
       "5:35: error P7307: \"slot\" does not belong to input \"X\"\n  help: echo only, outputs only: take it out\n"},
      {input + ", channel = 1 }\n",
       "5:35: error P7307: \"channel\" does not belong to input \"X\"\n  help: gpio, simulated only: take it out\n"},
      {start + "[outputs]\nX = { driver = \"cave\" }\n",
       "5:1: error P7306: output \"X\" has no \"slot\"\n  help: add slot = 7\n"},
      {start + "[outputs]\nX = { driver = \"cave\", slot = 4 }\nY = { driver = \"cave\", slot = 4 }\n",
       "6:1: error P7310: slot 4 of cave is used already, by \"X\" in line 5\n"},
      {"[drivers.cave]\nkind = \"echo\"\nplace = \"cave\"\ndelay = 0\n[inputs]\nX = { driver = \"cave\", hears = 1 }\n",
       "4:9: error P7311: an echo is never at once\n"},
  };
  for (const auto& [text, problem] : rows) EXPECT_EQ(Read(text).problems(), "plc.toml:" + problem) << text;
}

TEST(ThirdKind, VariablesThatDoNotFitAreRefused) {
  const Read read(
      "[drivers.cave]\nkind = \"echo\"\nplace = \"cave\"\n[outputs]\n"
      "\"%QW0\" = { driver = \"cave\", slot = 1 }\nLevel = { driver = \"cave\", slot = 2 }\n");
  const auto resource = counter();
  core::Diagnostics diagnostics;
  EXPECT_FALSE(bind(read.configuration.value(), *resource, diagnostics).has_value());
  ASSERT_EQ(diagnostics.all().size(), 2u) << "and %QD1 leads to no channel";
  EXPECT_EQ(diagnostics.all()[1].message, "\"Level\" has type REAL, an echo carries an INT");
  EXPECT_EQ(diagnostics.all()[1].at.line, 6u);
}

std::string uncommented(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    const bool setting = text[at] == '#' && at + 1 < end && text[at + 1] != ' ';
    out += text.substr(at + (setting ? 1 : 0), end + 1 - at - (setting ? 1 : 0));
    at = end + 1;
  }
  return out;
}

TEST(ThirdKind, TheTemplateHasItsKeysAndChannels) {
  const auto resource = counter();
  const DriverType* const only[] = {&kEchoType, &kSimulatedType};
  const std::string text = configuration_template(*resource, "p.st", only);
  for (const char* part :
       {"# echo: what is written is heard again. simulated: no device;", "#[drivers.cave]\n", "#kind = \"echo\"\n",
        "# Cycles until the echo. Takes a whole number from 0 to 9. (echo only)\n#delay = 1\n", "#place = \"cave\"\n",
        "#   gain: Factor. Takes a whole number from 1 to 9. (echo only, outputs only)\n",
        "#\"%IW0\" = { driver = \"cave\", slot = 7 }", "#\"%QW0\" = { driver = \"plant\", safe = 0 }",
        "#\"%QD1\" = { driver = \"plant\", safe = 0 }"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in:\n" << text;
  }
  const Read with_all(uncommented(configuration_template(*resource, "p.st", types())));
  ASSERT_TRUE(with_all.configuration.has_value()) << with_all.problems();
  EXPECT_EQ(with_all.configuration->driver("cave")->type, &kEchoType);
}

TEST(ThirdKind, TheReferenceHasItsKeys) {
  const std::string text = configuration_reference(types());
  for (const char* part : {"outputs go nowhere. modbus: a Modbus device, over TCP or a serial line. echo: what is "
                           "written is heard again. |",
                           "| `delay` | a whole number from 0 to 9; echo only | `1` | Cycles until the echo. |",
                           "| `place` | a text; echo only | required | Where it echoes; nothing does in the void. |",
                           "| `gain` | a whole number from 1 to 9; echo only, outputs only | `1` | Factor. |"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
}

/// Stops the scheduler when so many scans have begun.
class Limit final : public runtime::CycleListener {
 public:
  Limit(runtime::RealtimeScheduler& scheduler, std::uint64_t cycles) : scheduler_(scheduler), cycles_(cycles) {}
  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext& context) noexcept override {
    if (context.cycle + 1 >= cycles_) scheduler_.request_stop();
  }
  void safe_state() noexcept override {}

 private:
  runtime::RealtimeScheduler& scheduler_;
  std::uint64_t cycles_;
};

/// "In" after six scans on a machine with this file.
std::string heard(const std::string& text, bool simulate = false) {
  Read read(text);
  if (!read.configuration) return read.problems();
  const auto resource = counter();
  const auto machine = Machine::configure(
      {.project = "p.st", .configuration = std::move(*read.configuration), .modbus = {}, .simulate = simulate},
      *resource, read.diagnostics);
  if (machine == nullptr) return read.problems();
  EXPECT_EQ(machine->open(), std::nullopt);
  runtime::RealtimeScheduler scheduler(*resource);
  std::vector<Sentence> notes;
  machine->start(scheduler, notes);
  Limit limit(scheduler, 6);
  scheduler.add_listener(limit);
  scheduler.start();
  scheduler.join();
  machine->stop();
  const runtime::Access access(*resource);
  return access.read(*access.find("In"));
}

TEST(ThirdKind, RunsInAMachine) {
  EXPECT_EQ(heard(kCave + "delay = 1\n" + kChannels), "2") << "one more in every second scan";
  EXPECT_EQ(heard(kCave + "delay = 3\nanswer = \"negated\"\n" + kChannels), "-1");
}

TEST(ThirdKind, SimulationPutsAnotherInItsPlace) {
  made = 0;
  EXPECT_EQ(heard(kCave + kChannels, true), "0");
  EXPECT_EQ(made, 0);
}

TEST(ThirdKind, ProblemsOfTheDeviceAreReportedAtItsKey) {
  const std::string problems =
      heard("[modbus]\nlisten = \"off\"\n[drivers.cave]\nkind = \"echo\"\nplace = \"void\"\n" + kChannels);
  EXPECT_NE(problems.find("plc.toml:5:9: error P7401: the void does not answer\n"), std::string::npos) << problems;
}

}  // namespace
}  // namespace plc::io
