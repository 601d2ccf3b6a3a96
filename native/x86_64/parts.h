// Elements of arrays, after one index or several.
//
// In: instructions of the forms kLoadElement to kStorePath. Out: code. A part of translate_data.cpp.
#pragma once

#include "native/translate.h"

namespace plc::native {

void load_part(Assembly& assembly, const Instruction& instruction);
void store_part(Assembly& assembly, const Instruction& instruction);

}  // namespace plc::native
