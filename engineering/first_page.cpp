#include "engineering/first_page.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/text.h"
#include "engineering/value_json.h"
#include "taskblocks/registry.h"

namespace plc::engineering {
namespace {

using hmi::Element;
using hmi::Kind;

/// A page with more is no page: the page of variables has all of them.
constexpr std::size_t kMostElements = 200;
constexpr std::size_t kMostInstances = 30;
constexpr std::size_t kMostBelow = 500;
constexpr std::int64_t kWidth = 4, kHeight = 2;
/// So that there is room for more when it is edited.
constexpr std::int64_t kLeastRows = 10;

class Maker {
 public:
  Maker(const Variables& variables, const std::string& title) : variables_(variables) {
    page_.name = "first";
    page_.title = title;
  }

  hmi::Document make() {
    std::size_t total = 0;
    const auto roots = variables_.children({}, 0, 2 * kMostBelow, total);
    std::vector<Node> globals, others, structures;
    std::size_t instances = 0;
    for (const Node& node : *roots) {
      if (is_shown(node)) globals.push_back(node);
      if ((node.kind != "structure" && node.kind != "list") || ++instances > kMostInstances) continue;
      const auto below = variables_.children(node.path, 0, kMostBelow, total);
      if (!below) continue;
      for (const Node& one : *below) {
        if (is_shown(one)) (node.kind == "list" ? globals : others).push_back(one);
        if (one.kind == "structure") structures.push_back(one);
      }
    }
    add_groups(globals, others);
    for (const Node& one : structures) add_taskblock(one);
    page_.rows = std::clamp<std::int64_t>(y_ + (x_ == 0 ? 0 : kHeight), kLeastRows, hmi::kMostCells);
    hmi::Document document;
    document.pages.push_back(std::move(page_));
    return document;
  }

 private:
  [[nodiscard]] bool is_shown(const Node& node) const {
    return node.kind == "value" && node.place && variables_.is_readable(*node.place);
  }

  void add_groups(const std::vector<Node>& globals, const std::vector<Node>& others) {
    // A program that uses a global at an address has it among its own.
    std::vector<Node> located;
    std::set<std::pair<std::string_view, std::string>> known;
    for (const auto* const nodes : {&globals, &others}) {
      for (const Node& node : *nodes) {
        const std::string_view address = variables_.address(*node.place);
        if (!address.empty() && known.emplace(address, node.name).second) located.push_back(node);
      }
    }
    const std::pair<std::string_view, std::string_view> groups[] = {
        {"%I", "Inputs"}, {"%Q", "Outputs"}, {"%M", "Memory"}, {"", "Globals"}};
    const std::vector<Node>& shown = located.empty() ? globals : located;
    for (const auto& [area, title] : groups) {
      std::vector<Element> elements;
      for (const Node& node : shown) {
        const std::string address = core::uppered(variables_.address(*node.place).substr(0, 2));
        const bool is_other = address != "%I" && address != "%Q" && address != "%M";
        if (area.empty() ? is_other : address == area) elements.push_back(element_of(node, address == "%Q"));
      }
      add_group(title, std::move(elements));
    }
  }

  [[nodiscard]] Element element_of(const Node& node, bool output) const {
    Element element;
    element.kind = Kind::kNumber;
    if (type_name(variables_.image(), node.place->type) == "BOOL") {
      // Outputs belong to the program: what is written to them is gone with its next scan.
      element.kind = variables_.is_writable(*node.place) && !output ? Kind::kSwitch : Kind::kLamp;
    }
    element.values[hmi::key("label")] = node.name.substr(0, hmi::kMostText);
    element.values[hmi::key("variable")] = node.path;
    return element;
  }

  /// What goes into and comes out of a taskblock, with the units that its ports declare.
  void add_taskblock(const Node& node) {
    const bytecode::Image& image = variables_.image();
    const auto block = std::find_if(image.blocks.begin(), image.blocks.end(),
                                    [&](const auto& one) { return one.type == node.place->type; });
    if (block == image.blocks.end()) return;
    const auto* const entry = taskblocks::Registry::built_in().find(block->name);
    if (entry == nullptr) return;
    std::size_t total = 0;
    const auto ports = variables_.children(node.path, 0, kMostBelow, total);
    if (!ports) return;
    std::map<std::string_view, const picard_port*> declared;
    for (std::uint32_t i = 0; i < entry->block->port_count; ++i) {
      declared[entry->block->ports[i].name] = &entry->block->ports[i];
    }
    std::vector<Element> elements;
    for (const Node& port : *ports) {
      const auto found = declared.find(port.name);
      if (!is_shown(port) || found == declared.end() || found->second->direction > PICARD_OUTPUT) continue;
      Element element = element_of(port, true);
      if (element.kind == Kind::kNumber) element.values[hmi::key("unit")] = std::string(found->second->unit);
      elements.push_back(std::move(element));
    }
    add_group(node.path + " (" + block->name + ")", std::move(elements));
  }

  void add_group(std::string_view title, std::vector<Element> elements) {
    if (elements.empty() || page_.elements.size() >= kMostElements) return;
    if (x_ != 0) next_row();
    Element heading;
    heading.kind = Kind::kText;
    heading.values[hmi::key("text")] = std::string(title.substr(0, hmi::kMostText));
    place(std::move(heading), hmi::kColumns, 1);
    x_ = 0;
    ++y_;
    for (Element& element : elements) {
      if (page_.elements.size() >= kMostElements || y_ + kHeight > hmi::kMostCells) break;
      place(std::move(element), kWidth, kHeight);
      x_ += kWidth;
      if (x_ + kWidth > hmi::kColumns) next_row();
    }
  }

  void next_row() {
    x_ = 0;
    y_ += kHeight;
  }

  void place(Element element, std::int64_t width, std::int64_t height) {
    element.x = x_;
    element.y = y_;
    element.width = width;
    element.height = height;
    page_.elements.push_back(std::move(element));
  }

  const Variables& variables_;
  hmi::Page page_;
  std::int64_t x_ = 0, y_ = 0;
};

}  // namespace

hmi::Document first_page(const Variables& variables, const std::string& title) {
  return Maker(variables, title).make();
}

}  // namespace plc::engineering
