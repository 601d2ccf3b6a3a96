#include "taskblocks/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/text.h"
#include "core/types.h"
#include "taskblocks/set.h"

namespace plc::taskblocks {
namespace {

bool is_name(const char* text) {
  if (text == nullptr || text[0] == '\0' || std::isdigit(static_cast<unsigned char>(text[0])) != 0) return false;
  const std::string_view name = text;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return std::isupper(static_cast<unsigned char>(c)) != 0 || std::isdigit(static_cast<unsigned char>(c)) != 0 ||
           c == '_';
  });
}

/// What is wrong with a type, or nothing.
std::string complaint(const picard_type& type, int depth = 0) {
  constexpr int kDeepest = 8;
  if (depth > kDeepest) return "a type is nested too deeply";
  switch (type.kind) {
    case PICARD_ELEMENTARY: {
      const auto id = core::type_named(type.name);
      if (!id || core::rep_bytes(core::rep_of(*id)) != type.size) {
        return fmt::format("\"{}\" of {} bytes is no elementary type", type.name, type.size);
      }
      return {};
    }
    case PICARD_STRING:
      return type.capacity >= 1 && type.capacity <= 65535 ? "" : "a string of no length";
    case PICARD_ARRAY:
      if (type.capacity < 1 || type.element == nullptr) return "an array without elements";
      return complaint(*type.element, depth + 1);
    case PICARD_STRUCT_TYPE:
      if (!is_name(type.name)) return fmt::format("\"{}\" is no name for a structure", type.name);
      for (std::uint32_t i = 0; i < type.field_count; ++i) {
        if (std::string wrong = complaint(*type.fields[i].type, depth + 1); !wrong.empty()) return wrong;
      }
      return type.field_count == 0 ? "a structure without fields" : "";
    case PICARD_ENUM_TYPE: {
      if (!is_name(type.name)) return fmt::format("\"{}\" is no name for an enumeration", type.name);
      if (type.enumerator_count == 0) return "an enumeration without values";
      const auto base = core::type_named(type.element->name);
      if (!base || !core::in_category(*base, core::kAnyInt) || type.element->size != type.size) {
        return fmt::format("an enumeration of {}, which is no integer type", type.element->name);
      }
      return complaint(*type.element, depth + 1);
    }
    default:
      return fmt::format("type of kind {}", type.kind);
  }
}

std::string complaint(const picard_block& block) {
  if (!is_name(block.name)) {
    return fmt::format("\"{}\" is no name for a taskblock: capital letters, digits and underscores", block.name);
  }
  for (std::uint32_t i = 0; i < block.port_count; ++i) {
    const picard_port& port = block.ports[i];
    if (!is_name(port.name)) return fmt::format("{}: \"{}\" is no name for a port", block.name, port.name);
    for (std::uint32_t k = 0; k < i; ++k) {
      if (std::string_view(block.ports[k].name) == port.name) {
        return fmt::format("{}: two ports are called {}", block.name, port.name);
      }
    }
    if (std::string wrong = complaint(*port.type); !wrong.empty()) {
      return fmt::format("{}, port {}: {}", block.name, port.name, wrong);
    }
  }
  return {};
}

class Hash {
 public:
  void add(std::string_view text) {
    for (const char c : text) add_byte(static_cast<unsigned char>(c));
    add_byte(0);
  }
  void add_byte(unsigned char byte) { value_ = (value_ ^ byte) * 0x100000001b3ull; }
  [[nodiscard]] std::uint64_t value() const { return value_ == 0 ? 1 : value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ull;  // FNV-1a
};

void add(Hash& hash, const picard_type& type) {
  hash.add(type_text(type));
  if (type.element != nullptr) add(hash, *type.element);
  for (std::uint32_t i = 0; i < type.field_count; ++i) {
    hash.add(type.fields[i].name);
    add(hash, *type.fields[i].type);
  }
  for (std::uint32_t i = 0; i < type.enumerator_count; ++i) {
    hash.add(type.enumerators[i].name);
    hash.add(std::to_string(type.enumerators[i].value));
  }
}

void collect(const picard_type& type, std::vector<const picard_type*>& types) {
  if (type.element != nullptr) collect(*type.element, types);
  for (std::uint32_t i = 0; i < type.field_count; ++i) collect(*type.fields[i].type, types);
  if (type.kind != PICARD_STRUCT_TYPE && type.kind != PICARD_ENUM_TYPE) return;
  const bool known = std::any_of(types.begin(), types.end(),
                                 [&type](const picard_type* other) { return core::iequals(other->name, type.name); });
  if (!known) types.push_back(&type);
}

/// The summary as a comment; nothing in it ends the comment.
std::string comment(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '*' ? '+' : c;
  return out;
}

}  // namespace

const Registry& Registry::built_in() {
  static const Registry registry = [] {
    Registry made;
    for (const picard_library* library : blocks::linked_libraries()) {
      if (const auto problem = made.add(library)) throw std::logic_error(problem->message);
    }
    return made;
  }();
  return registry;
}

std::optional<core::Problem> Registry::add(const picard_library* library, const std::string& source) {
  const std::string what = source.empty() ? std::string("taskblock library") : source;
  const auto refused = [&what](const std::string& why) {
    return core::Problem{core::Code::P7801, what + ": " + why, "build it against the SDK of this version of PICARD"};
  };
  if (library == nullptr) return refused("it has no description");
  if (library->abi_version == 0 || library->abi_version > PICARD_ABI_VERSION) {
    return refused(fmt::format("it speaks version {} of the taskblock interface, this program version {}",
                               library->abi_version, PICARD_ABI_VERSION));
  }
  if (library->block_bytes != sizeof(picard_block) || library->port_bytes != sizeof(picard_port) ||
      library->type_bytes != sizeof(picard_type)) {
    return refused("its structures have other sizes than this program's");
  }
  if (library->failure != nullptr) return refused(fmt::format("a constructor failed: {}", library->failure));
  const std::size_t before = entries_.size();
  for (std::uint32_t i = 0; i < library->block_count; ++i) {
    const picard_block& block = library->blocks[i];
    std::string wrong = complaint(block);
    if (wrong.empty() && find(block.name) != nullptr) wrong = fmt::format("{} is there already", block.name);
    if (!wrong.empty()) {
      entries_.resize(before);
      return refused(wrong);
    }
    entries_.push_back({library, &block, source});
  }
  return {};
}

const Registry::Entry* Registry::find(std::string_view name) const {
  const auto at = std::find_if(entries_.begin(), entries_.end(),
                               [name](const Entry& entry) { return core::iequals(entry.block->name, name); });
  return at == entries_.end() ? nullptr : &*at;
}

std::uint64_t layout_hash(const picard_block& block) {
  Hash hash;
  hash.add(block.name);
  for (std::uint32_t i = 0; i < block.port_count; ++i) {
    hash.add(block.ports[i].name);
    hash.add_byte(static_cast<unsigned char>(block.ports[i].direction));
    add(hash, *block.ports[i].type);
  }
  return hash.value();
}

std::string type_text(const picard_type& type) {
  switch (type.kind) {
    case PICARD_STRING:
      return fmt::format("{}[{}]", type.name, type.capacity);
    case PICARD_ARRAY:
      return fmt::format("ARRAY [0..{}] OF {}", type.capacity - 1, type_text(*type.element));
    default:
      return type.name;
  }
}

std::vector<const picard_type*> data_types_of(const picard_block& block) {
  std::vector<const picard_type*> types;
  for (std::uint32_t i = 0; i < block.port_count; ++i) collect(*block.ports[i].type, types);
  return types;
}

std::string declaration(const picard_type& type) {
  if (type.kind == PICARD_ENUM_TYPE) {
    std::string values;
    for (std::uint32_t i = 0; i < type.enumerator_count; ++i) {
      values += fmt::format("{}{} := {}", i == 0 ? "" : ", ", type.enumerators[i].name, type.enumerators[i].value);
    }
    return fmt::format("TYPE {} : {} ({}); END_TYPE\n", type.name, type.element->name, values);
  }
  std::string text = fmt::format("TYPE {} : STRUCT\n", type.name);
  for (std::uint32_t i = 0; i < type.field_count; ++i) {
    text += fmt::format("  {} : {};\n", type.fields[i].name, type_text(*type.fields[i].type));
  }
  return text + "END_STRUCT; END_TYPE\n";
}

std::string block_declaration(const picard_block& block) {
  std::string text = fmt::format("FUNCTION_BLOCK {} (* {} *)\n", block.name, comment(block.summary));
  const auto section = [&](std::string_view head, std::uint32_t direction) {
    bool open = false;
    for (std::uint32_t i = 0; i < block.port_count; ++i) {
      const picard_port& port = block.ports[i];
      if (port.direction != direction) continue;
      if (!open) text += fmt::format("{}\n", head);
      open = true;
      const std::string_view initial = port.initial;
      const std::string_view unit = port.unit;
      const bool queue = direction == PICARD_QUEUE_READER || direction == PICARD_QUEUE_WRITER;
      text += fmt::format("  {} : {}{}{}{}; (* {}{} *)\n", port.name, queue ? "ARRAY [*] OF " : "",
                          type_text(*port.type), initial.empty() ? "" : " := ", initial, comment(port.summary),
                          unit.empty() ? "" : ", " + comment(unit));
    }
    if (open) text += "END_VAR\n";
  };
  section("VAR_INPUT", PICARD_INPUT);
  section("VAR_INPUT CONSTANT", PICARD_CONFIG);
  section("VAR_OUTPUT", PICARD_OUTPUT);
  // The global array that is named here is the queue; CONSTANT: elements are taken out of it.
  section("VAR_IN_OUT", PICARD_QUEUE_WRITER);
  section("VAR_IN_OUT CONSTANT", PICARD_QUEUE_READER);
  return text + "END_FUNCTION_BLOCK\n";
}

std::string declaration(const picard_block& block) {
  std::string text;
  for (const picard_type* type : data_types_of(block)) text += declaration(*type);
  return text + block_declaration(block);
}

}  // namespace plc::taskblocks
