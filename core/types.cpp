#include "core/types.h"

#include "core/text.h"

namespace plc::core {

std::string_view rep_name(Rep rep) {
  constexpr std::string_view kNames[kRepCount] = {"bool", "i8",  "u8",  "i16", "u16", "i32",  "u32",
                                                  "i64",  "u64", "f32", "f64", "str", "wstr", "ref"};
  return kNames[static_cast<std::size_t>(rep)];
}

std::optional<TypeId> type_named(std::string_view name) {
  for (std::size_t i = 0; i < kTypeCount; ++i) {
    if (iequals(kTypes[i].iec, name) || (!kTypes[i].alias.empty() && iequals(kTypes[i].alias, name))) {
      return static_cast<TypeId>(i);
    }
  }
  return std::nullopt;
}

}  // namespace plc::core
