// The sides of `plc-bench scan`: one program made to run by the C compiler, in the interpreter, and as native code.
//
// In: a Source. Out: a scan, and where its variables lie. Does not belong here: what programs do (workload.h),
// comparing and timing (scan.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "bench/workload.h"
#include "bytecode/image.h"
#include "core/clock.h"

namespace plc::bench {

/// What a scan goes through, bytes.
struct Footprint {
  std::size_t code = 0;  ///< machine code
  std::size_t data = 0;  ///< variables, and of the interpreter its instructions
};

/// One of those that do the same.
class Side {
 public:
  virtual ~Side() = default;
  /// False when the scan ended in a fault.
  virtual bool scan(core::TimeNs now_ns) = 0;
  /// In the order of Source::variables. Between scans.
  [[nodiscard]] const std::vector<unsigned char*>& variables() const { return variables_; }
  [[nodiscard]] const Footprint& footprint() const { return footprint_; }

 protected:
  std::vector<unsigned char*> variables_;
  Footprint footprint_;
};

enum class Engine : std::uint8_t { kInterpreter, kNative };

/// Each of them is null when that cannot be made; why is on stderr. The C side needs the image for its taskblocks only.
std::unique_ptr<Side> make_c_side(const bytecode::VerifiedImage& image, const Source& source, bool barriers);
std::unique_ptr<Side> make_plc_side(const bytecode::VerifiedImage& image, const Source& source, Engine engine);

/// Through the whole pipeline. Nothing when the project does not compile; why is on stderr.
std::optional<bytecode::VerifiedImage> compile_project(const Source& source);

}  // namespace plc::bench
