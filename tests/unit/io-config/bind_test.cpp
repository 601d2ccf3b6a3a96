#include "io-drivers/config/bind.h"

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>

#include "io-drivers/machine/driver_types.h"
#include "tests/support/image_builder.h"

namespace plc::io {
namespace {

using bytecode::Opcode;
using bytecode::PouKind;
using core::TypeId;
using test::ImageBuilder;
using test::PouBuilder;

/// Two tasks, Slow before Fast; inputs, outputs, memory, and things that no driver may have.
std::unique_ptr<runtime::Resource> plant(bool with_event_task = false) {
  ImageBuilder b;
  const auto input = [](std::string address) {
    return ImageBuilder::GlobalOptions{.input = true, .address = std::move(address)};
  };
  const auto output = [](std::string address) { return ImageBuilder::GlobalOptions{.address = std::move(address)}; };
  b.global("Start", b.boolean(), {}, input("%IX0.0"));                                         // 0
  b.global("Stop", b.boolean(), {}, input("%IX0.1"));                                          // 1
  b.global("Level", b.type(TypeId::kInt), {}, input("%IW0"));                                  // 2
  b.global("Sensors", b.array(b.boolean(), 4, 1), {}, input("%IX2.0"));                        // 3
  b.global("Pump", b.boolean(), {}, output("%QX0.0"));                                         // 4
  b.global("Lamp", b.boolean(), {}, output("%QX0.1"));                                         // 5
  b.global("Speed", b.type(TypeId::kInt), {}, output("%QW0"));                                 // 6
  b.global("Mode", b.limited(TypeId::kInt, 2, 5, "Mode"), {}, output("%QW1"));                 // 7
  b.global("Text", b.string(4), {}, output(""));                                               // 8
  b.global("Limit", b.type(TypeId::kInt), {}, ImageBuilder::GlobalOptions{.constant = true});  // 9
  b.global("Healthy", b.boolean(), {}, ImageBuilder::GlobalOptions{.input = true});            // 10
  b.global("Idle", b.boolean(), {}, input("%QX7.0"));                                          // 11: nobody writes it
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  main.variable("Local", b.boolean());
  main.alias("Motor", 4);
  const std::uint32_t program = main.finish();
  b.task("Slow", 100'000'000, {program});
  b.task("Fast", 20'000'000, {});
  if (with_event_task) b.task("Event", 0, {}, 0, "Start");
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(b.build(), diagnostics);
  for (const core::Diagnostic& d : diagnostics.all()) ADD_FAILURE() << diagnostics.render_one(d);
  auto resource = runtime::Resource::load(std::move(verified.value()));
  return std::move(resource.value());
}

constexpr const char* kDrivers =
    "[drivers.panel]\nkind = \"gpio\"\nchip = \"gpiochip0\"\n"  // lines 1..3
    "[drivers.bench]\nkind = \"simulated\"\n";                  // lines 4..5

struct Bound {
  std::unique_ptr<runtime::Resource> resource = plant();
  std::optional<Configuration> configuration;
  std::optional<Binding> binding;
  core::Diagnostics diagnostics;
  std::string problems;  ///< "line:column code", one a line, without P7326
  std::size_t unmapped = 0;

  explicit Bound(const std::string& text, bool with_event_task = false) : resource(plant(with_event_task)) {
    configuration = read_configuration(text, "plc.toml", driver_types(), diagnostics);
    if (configuration) binding = bind(*configuration, *resource, diagnostics);
    for (const core::Diagnostic& d : diagnostics.all()) {
      if (d.code == core::Code::P7326) {
        ++unmapped;
        continue;
      }
      problems += (problems.empty() ? "" : "\n") + std::to_string(d.at.line) + ':' + std::to_string(d.at.column) + ' ' +
                  std::string(core::info(d.code).name);
    }
  }
  [[nodiscard]] std::string rendered() const {
    std::string all;
    for (const core::Diagnostic& d : diagnostics.all()) all += diagnostics.render_one(d) + '\n';
    return all;
  }
};

const bytecode::ImageField& field(const Bound& bound, const BoundChannel& channel) {
  const bytecode::Image& image = bound.resource->image();
  return image.types[image.global_type].fields[channel.field];
}

TEST(Bind, VariablesBecomePlaces) {
  const Bound bound(std::string(kDrivers) + R"(task = "slow"
ok = "Healthy"
[inputs]
"%IX0.0" = { driver = "panel", channel = 17 }
stop = { driver = "panel", channel = 18 }
"Sensors[3]" = { driver = "bench" }
[outputs]
"%QX0.0" = { driver = "panel", channel = 22, safe = true }
"%QW0" = { driver = "bench", safe = -5, initial = "16#10" }
Text = { driver = "bench", safe = "off" }
)");
  ASSERT_TRUE(bound.binding.has_value()) << bound.rendered();
  EXPECT_EQ(bound.problems, "");
  ASSERT_EQ(bound.binding->drivers.size(), 2u);
  const BoundDriver& panel = bound.binding->drivers[0];
  EXPECT_EQ(panel.config, &bound.configuration->drivers[0]);
  EXPECT_EQ(panel.task, 1u) << "the fastest task, not the first";
  ASSERT_EQ(panel.inputs.size(), 2u);
  EXPECT_EQ(field(bound, panel.inputs[0]).name, "Start");
  EXPECT_EQ(panel.inputs[0].offset, field(bound, panel.inputs[0]).offset);
  EXPECT_EQ(panel.inputs[0].config->values.text("channel"), "17");
  EXPECT_EQ(field(bound, panel.inputs[1]).name, "Stop");
  ASSERT_EQ(panel.outputs.size(), 1u);
  EXPECT_EQ(panel.outputs[0].safe, std::vector<std::byte>{std::byte{1}});
  EXPECT_EQ(panel.outputs[0].initial, std::vector<std::byte>{std::byte{1}}) << "safe, when nothing else is said";
  EXPECT_FALSE(panel.ok.has_value());

  const BoundDriver& bench = bound.binding->drivers[1];
  EXPECT_EQ(bench.task, 0u);
  ASSERT_TRUE(bench.ok.has_value());
  EXPECT_EQ(field(bound, *bench.ok).name, "Healthy");
  ASSERT_EQ(bench.inputs.size(), 1u);
  EXPECT_EQ(field(bound, bench.inputs[0]).name, "Sensors");
  EXPECT_EQ(bench.inputs[0].offset, field(bound, bench.inputs[0]).offset + 2);
  EXPECT_EQ(bound.resource->image().types[bench.inputs[0].type].elementary, TypeId::kBool);
  ASSERT_EQ(bench.outputs.size(), 2u);
  const auto number = [](const std::vector<std::byte>& bytes) {
    std::int16_t value = 0;
    EXPECT_EQ(bytes.size(), sizeof value);
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  };
  EXPECT_EQ(number(bench.outputs[0].safe), -5);
  EXPECT_EQ(number(bench.outputs[0].initial), 16);
  EXPECT_EQ(std::memcmp(bench.outputs[1].safe.data() + sizeof(core::StringHeader), "off", 3), 0);
}

TEST(Bind, ALocatedVariableOfAPouIsTheGlobal) {
  const Bound bound(std::string(kDrivers) + "[outputs]\n\"Main0.Motor\" = { driver = \"panel\", channel = 1 }\n");
  ASSERT_TRUE(bound.binding.has_value()) << bound.rendered();
  EXPECT_EQ(field(bound, bound.binding->drivers[0].outputs.at(0)).name, "Pump");
}

TEST(Bind, ClientSeenIsAnInputOfTheServer) {
  const Bound bound("[modbus]\nclient_seen = \"Healthy\"\n");
  ASSERT_TRUE(bound.binding.has_value()) << bound.rendered();
  ASSERT_TRUE(bound.binding->client_seen.has_value());
  EXPECT_EQ(field(bound, *bound.binding->client_seen).name, "Healthy");
  EXPECT_EQ(bound.unmapped, 0u) << "without drivers nothing is missing";
}

TEST(Bind, OutputsWithoutAChannelAreNamed) {
  const Bound bound(std::string(kDrivers) + "[outputs]\n\"%QX0.0\" = { driver = \"panel\", channel = 1 }\n");
  ASSERT_TRUE(bound.binding.has_value());
  EXPECT_EQ(bound.unmapped, 3u) << "no task writes %QX7.0\n" << bound.rendered();
  EXPECT_NE(bound.rendered().find("plc.toml:6:1: warning P7326: output %QX0.1 (Lamp) leads to no channel"),
            std::string::npos)
      << bound.rendered();
}

struct Wrong {
  const char* name;
  const char* text;      ///< after kDrivers: from line 6 on
  const char* problems;  ///< "line:column code", one a line
};
std::ostream& operator<<(std::ostream& out, const Wrong& wrong) { return out << wrong.name; }

constexpr Wrong kWrong[] = {
    {"UnknownVariable", "[inputs]\nStrat = { driver = \"panel\", channel = 1 }\n", "7:1 P7320"},
    {"UnknownAddress", "[inputs]\n\"%IX9.7\" = { driver = \"panel\", channel = 1 }\n", "7:1 P7320"},
    {"NoPath", "[inputs]\n\"a..b\" = { driver = \"panel\", channel = 1 }\n", "7:1 P7320"},
    {"WholeArray", "[inputs]\nSensors = { driver = \"panel\", channel = 1 }\n", "7:1 P7320"},
    {"IndexOutside", "[inputs]\n\"Sensors[0]\" = { driver = \"panel\", channel = 1 }\n", "7:1 P7320"},
    {"VariableOfATask", "[inputs]\n\"Main0.Local\" = { driver = \"panel\", channel = 1 }\n", "7:1 P7321"},
    {"WordOnALine", "[inputs]\n\"%IW0\" = { driver = \"panel\", channel = 1 }\n", "7:1 P7322"},
    {"InvertedWord", "[inputs]\n\"%IW0\" = { driver = \"bench\", invert = true }\n", "7:1 P7322"},
    {"CertificateWithoutKey", "[engineering]\ncertificate = \"plant.pem\"\n", "7:15 P7306"},
    {"KeyWithoutCertificate", "[engineering]\ncertificate = \"\"\nkey = \"plant.key\"\n", "8:7 P7306"},
    {"OkOfAWord", "ok = \"Level\"\n", "6:6 P7322"},
    {"InputThatAProgramWrites", "[inputs]\n\"%QX0.0\" = { driver = \"panel\", channel = 1 }\n", "7:1 P7323"},
    {"OkThatAProgramWrites", "ok = \"Pump\"\n", "6:6 P7323"},
    {"ConstantInput", "[inputs]\nLimit = { driver = \"bench\" }\n", "7:1 P7324"},
    {"ConstantOutput", "[outputs]\nLimit = { driver = \"bench\" }\n", "7:1 P7324"},
    {"NobodyWrites", "[outputs]\n\"%QX7.0\" = { driver = \"bench\" }\n", "7:1 P7325"},
    {"SafeOfAnotherType", "[outputs]\nPump = { driver = \"panel\", channel = 1, safe = 5 }\n", "7:48 P7327"},
    {"InitialOutOfRange", "[outputs]\nSpeed = { driver = \"bench\", initial = 40000 }\n", "7:39 P7327"},
    {"SafeOutsideTheSubrange", "[outputs]\nMode = { driver = \"bench\", safe = 6 }\n", "7:35 P7327"},
    {"NoSafeValueWhereZeroIsNone", "[outputs]\nMode = { driver = \"bench\" }\n", "7:1 P7327"},
    {"SafeTextTooLong", "[outputs]\nText = { driver = \"bench\", safe = \"12345\" }\n", "7:35 P7327"},
    {"UnknownTask", "task = \"Fats\"\n", "6:8 P7328"},
    {"AddressAndName",
     "[outputs]\n\"%QX0.0\" = { driver = \"panel\", channel = 1 }\nPump = { driver = \"panel\", channel = 2 }\n",
     "8:1 P7309"},
    {"PathAndAddress",
     "[outputs]\n\"Main0.Motor\" = { driver = \"panel\", channel = 1 }\n\"%QX0.0\" = { driver = \"panel\", channel = 2 "
     "}\n",
     "8:1 P7309"},
    {"OkIsAnInputToo", "ok = \"Start\"\n[inputs]\nStart = { driver = \"panel\", channel = 1 }\n", "6:6 P7309"},
    {"OneArrayFromTwoDrivers",
     "[inputs]\n\"Sensors[1]\" = { driver = \"panel\", channel = 1 }\n\"Sensors[2]\" = { driver = \"bench\" }\n",
     "8:1 P7330"},
    {"AllProblemsInOneRun",
     "task = \"None\"\n[inputs]\nNowhere = { driver = \"bench\" }\nLimit = { driver = \"bench\" }\n",
     "6:8 P7328\n8:1 P7320\n9:1 P7324"},
};

class WrongBinding : public testing::TestWithParam<Wrong> {};

TEST_P(WrongBinding, IsReportedAtItsPlace) {
  const Bound bound(std::string(kDrivers) + GetParam().text);
  EXPECT_EQ(bound.problems, GetParam().problems) << bound.rendered();
  const bool error = std::string_view(GetParam().problems).find("P7325") == std::string_view::npos;
  EXPECT_EQ(bound.binding.has_value(), !error);
}

INSTANTIATE_TEST_SUITE_P(Files, WrongBinding, testing::ValuesIn(kWrong),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(Bind, HelpsWithNames) {
  const Bound variable(std::string(kDrivers) + "[inputs]\nStrat = { driver = \"panel\", channel = 1 }\n");
  EXPECT_NE(variable.rendered().find("did you mean \"Start\"?"), std::string::npos) << variable.rendered();
  const Bound task(std::string(kDrivers) + "task = \"Fats\"\n");
  EXPECT_NE(task.rendered().find("did you mean \"Fast\"?"), std::string::npos) << task.rendered();
  const Bound other(std::string(kDrivers) + "task = \"Nothing\"\n");
  EXPECT_NE(other.rendered().find("the project has Slow, Fast"), std::string::npos) << other.rendered();
}

TEST(Bind, AnEventTaskIsWarnedAbout) {
  const Bound bound(std::string(kDrivers) + "task = \"Event\"\n", true);
  ASSERT_TRUE(bound.binding.has_value()) << bound.rendered();
  EXPECT_EQ(bound.problems, "6:8 P7329");
  EXPECT_EQ(bound.binding->drivers[1].task, 2u);
  EXPECT_EQ(bound.binding->drivers[0].task, 1u) << "never by itself";
}

TEST(FastestTask, IntervalsBeforeFreewheelingBeforeEvents) {
  bytecode::Image image;
  const auto task = [&](std::int64_t period, std::int32_t priority, const char* single) {
    bytecode::ImageTask t;
    t.period_ns = period;
    t.priority = priority;
    t.single = single;
    image.tasks.push_back(t);
    return fastest_task(image);
  };
  EXPECT_EQ(task(0, 0, "Start"), 0u);
  EXPECT_EQ(task(0, 5, ""), 1u);
  EXPECT_EQ(task(50, 5, ""), 2u);
  EXPECT_EQ(task(10, 5, ""), 3u);
  EXPECT_EQ(task(10, 1, ""), 4u);
  EXPECT_EQ(task(1, 0, "Start"), 4u);
}

}  // namespace
}  // namespace plc::io
