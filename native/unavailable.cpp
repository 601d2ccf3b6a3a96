// compile() on processors that there is no code generator for.
#include "native/compile.h"

namespace plc::native {

core::Result<std::unique_ptr<NativeTask>> compile(runtime::Program&, const CompileOptions&) {
  return core::Problem{core::Code::P9001, "there is no native code for this processor", {}};
}

}  // namespace plc::native
