// What `plc config init` writes passes its own checks, as it is and with every setting uncommented.
#include "io-drivers/config/template.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "io-drivers/config/bind.h"
#include "io-drivers/config/driver_type.h"
#include "io-drivers/machine/driver_types.h"
#include "tests/support/image_builder.h"

namespace plc::io {
namespace {

using bytecode::PouKind;
using core::TypeId;
using test::ImageBuilder;
using test::PouBuilder;

std::unique_ptr<runtime::Resource> load(ImageBuilder& b) {
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(b.build(), diagnostics);
  for (const core::Diagnostic& d : diagnostics.all()) ADD_FAILURE() << diagnostics.render_one(d);
  auto resource = runtime::Resource::load(std::move(verified.value()));
  return std::move(resource.value());
}

/// Located variables of many kinds, also such that no device can have.
std::unique_ptr<runtime::Resource> plant() {
  ImageBuilder b;
  const auto input = [](std::string address) {
    return ImageBuilder::GlobalOptions{.input = true, .address = std::move(address)};
  };
  const auto output = [](std::string address) { return ImageBuilder::GlobalOptions{.address = std::move(address)}; };
  b.global("Start", b.boolean(), {}, input("%IX0.0"));
  b.global("Level", b.type(TypeId::kReal), {}, input("%ID0"));
  b.global("Bits", b.array(b.boolean(), 200, 1), {}, input("%IX100.0"));
  b.global("%IX0.5", b.boolean(), {}, input("%IX0.5"));
  b.global("Written", b.boolean(), {}, output("%IX0.6"));
  b.global("Fixed", b.type(TypeId::kInt), {}, ImageBuilder::GlobalOptions{.constant = true, .address = "%IW9"});
  b.global("Pump", b.boolean(), {}, output("%QX0.0"));
  b.global("Same", b.boolean(), {}, output("%QX0.0"));
  b.global("Mode", b.limited(TypeId::kInt, 2, 5, "Mode"), {}, output("%QW1"));
  b.global("Below", b.limited(TypeId::kInt, -5, -2, "Below"), {}, output("%QW2"));
  b.global("Letter", b.type(TypeId::kChar), {}, output("%QB9"));
  b.global("Delay", b.type(TypeId::kTime), {}, output("%QL1"));
  b.global("Text", b.string(4), {}, output("%QB20"));
  b.global("Pair", b.structure("Pair", {{"On", b.boolean()}, {"Speed", b.type(TypeId::kLreal)}}), {}, output("%QB30"));
  b.global("Memory", b.type(TypeId::kInt), {}, output("%MW0"));
  b.global("NoAddress", b.boolean());
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  main.alias("Door", 3);
  const std::uint32_t program = main.finish();
  b.task("Task \"A\"", 20'000'000, {program});
  return load(b);
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

struct Checked {
  std::optional<Configuration> configuration;
  std::optional<Binding> binding;
  std::string problems;
  Checked(const std::string& text, runtime::Resource& resource) {
    core::Diagnostics diagnostics;
    configuration = read_configuration(text, "plc.toml", driver_types(), diagnostics);
    if (configuration) binding = bind(*configuration, resource, diagnostics);
    for (const core::Diagnostic& d : diagnostics.all()) problems += diagnostics.render_one(d) + '\n';
  }
};

TEST(Template, AsItIsItSetsNothing) {
  const auto resource = plant();
  const Checked checked(configuration_template(*resource, "plant.xml", driver_types()), *resource);
  ASSERT_TRUE(checked.binding.has_value()) << checked.problems;
  EXPECT_EQ(checked.problems, "");
  EXPECT_TRUE(checked.configuration->drivers.empty());
  EXPECT_TRUE(checked.configuration->inputs.empty());
  EXPECT_TRUE(checked.configuration->outputs.empty());
  EXPECT_TRUE(checked.configuration->modbus.ranges.empty());
}

TEST(Template, UncommentedItConnectsEverything) {
  const auto resource = plant();
  const std::string text = uncommented(configuration_template(*resource, "plant.xml", driver_types()));
  const Checked checked(text, *resource);
  ASSERT_TRUE(checked.binding.has_value()) << checked.problems << text;
  EXPECT_EQ(checked.problems, "") << "every output is mapped";
  ASSERT_EQ(checked.binding->drivers.size(), driver_types().size());
  EXPECT_EQ(checked.configuration->drivers[0].task.text, "Task \"A\"");
  EXPECT_EQ(checked.configuration->drivers[0].type->name, "gpio");
  EXPECT_EQ(checked.configuration->drivers[1].type->name, "simulated");
  EXPECT_EQ(checked.configuration->modbus.ranges.size(), 1u);
  EXPECT_EQ(checked.configuration->modbus.unit_id, 1);
  const auto key_of = [](const BoundChannel& channel) { return channel.config->variable.text; };
  const auto& panel = checked.binding->drivers[0];
  ASSERT_EQ(panel.inputs.size(), 66u) << "two bits, and 64 of the large array";
  EXPECT_EQ(key_of(panel.inputs[0]), "%IX0.0");
  EXPECT_EQ(key_of(panel.inputs[1]), "%IX100.0[1]");
  ASSERT_EQ(panel.outputs.size(), 3u);
  EXPECT_EQ(key_of(panel.outputs[0]), "%QX0.0");
  EXPECT_EQ(key_of(panel.outputs[1]), "Same") << "its address leads to another variable";
  EXPECT_EQ(key_of(panel.outputs[2]), "%QB30.On");
  EXPECT_EQ(checked.binding->drivers[2].inputs.size(), 1u);
  EXPECT_EQ(checked.binding->drivers[2].outputs.size(), 4u) << "numbers and a text";
  EXPECT_EQ(checked.binding->drivers[1].outputs.size(), 2u) << "what no device takes";
}

TEST(Template, NamesEveryKeyAndEveryLocatedVariable) {
  const auto resource = plant();
  const std::string text = configuration_template(*resource, "plant.xml", driver_types());
  for (const Keys all(driver_types()); const KeyInfo& key : all.rows()) {
    const std::string start = (key.table == TableId::kChannel ? "#   " : "#") + std::string(key.name);
    EXPECT_NE(text.find("\n" + start), std::string::npos) << key.name;
  }
  for (const char* line :
       {"#\"%IX0.0\" = { driver = \"panel\", channel = 0 }  # Start: BOOL\n",
        "#\"%ID0\" = { driver = \"meter\", table = \"holding-registers\", address = 0 }  # Level: REAL\n",
        "  # Main0.Door: BOOL\n", "# %IX0.6 Written: task Task \"A\" writes it", "# %IW9 Fixed: a constant\n",
        "  # %QX0.0 Same: BOOL\n", "safe = 2 }  # Mode: Mode\n", "safe = -2 }", "  # Text: STRING[4]\n",
        "# %QB30 Pair\n", "#   %MW0 Memory\n", "# and so on\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << " in:\n" << text;
  }
  EXPECT_EQ(text.find("NoAddress"), std::string::npos);
}

TEST(Template, AProjectWithoutAddresses) {
  ImageBuilder b;
  b.task("T", 1'000'000, {b.pou("Main", PouKind::kProgram).finish()});
  const auto resource = load(b);
  const std::string text = configuration_template(*resource, "bad\nname.xml", driver_types());
  EXPECT_EQ(Checked(text, *resource).problems, "");
  EXPECT_EQ(Checked(uncommented(text), *resource).problems, "");
  EXPECT_NE(text.find("The project has no variable at a %I address."), std::string::npos);
}

}  // namespace
}  // namespace plc::io
