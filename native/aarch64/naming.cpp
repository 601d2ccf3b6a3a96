// AArch64 has no loads and stores of bytes that name their place by its distance from the code.
#include "native/naming.h"

namespace plc::native {

bool names_from_code() { return false; }

}  // namespace plc::native
