// Characters of strings, s[p], as calls of MID and REPLACE.
#include <fmt/format.h>

#include <array>

#include "ir/convert.h"

namespace plc::ir {

using stdlib::Overload;

// s[p] is the one character that MID takes and REPLACE puts: what happens outside of the string is theirs.
ValueId Builder::character_of(ValueId string, ValueId position) {
  const TypeId text = module_.types[type_of(string)].elementary;
  const TypeId index = *module_.types.elementary_of(type_of(position));
  const TypeId character = text == TypeId::kWstring ? TypeId::kWchar : TypeId::kChar;
  const ValueId one = constant({ref_of(index), 1, {}});
  const Overload* const mid =
      stdlib::overload_with_key(fmt::format("MID:{},{}", core::name_of(text), core::name_of(index)));
  const ValueId taken = call_overload(*mid, std::array{string, one, position}, module_.types.string(text, 1));
  return call_overload(*conversion(text, character), std::array{taken}, ref_of(character));
}

ValueId Builder::with_character(ValueId string, ValueId character, ValueId position) {
  const TypeId text = module_.types[type_of(string)].elementary;
  const TypeId index = *module_.types.elementary_of(type_of(position));
  const ValueId one = constant({ref_of(index), 1, {}});
  const Overload* const put = conversion(*module_.types.elementary_of(type_of(character)), text);
  const ValueId piece = call_overload(*put, std::array{character}, module_.types.string(text, 1));
  const Overload* const replace =
      stdlib::overload_with_key(fmt::format("REPLACE:{},{}", core::name_of(text), core::name_of(index)));
  return call_overload(*replace, std::array{string, piece, one, position}, type_of(string));
}

}  // namespace plc::ir
