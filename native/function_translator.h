// FunctionTranslator: which part of a translator a function of the library goes to, on any processor.
//
// In: a call of a function that function_of() knows (library_rows.h). Out: code, by the class of a processor that
// derives from it (translate_library.cpp). Each part does what the kernel of its row does; what it leaves out, events
// above all, it leaves to the kernel. Does not belong here: instructions.
#pragma once

#include <cstdint>
#include <functional>

#include "native/library_rows.h"
#include "native/translate.h"

namespace plc::native {

class FunctionTranslator {
 public:
  FunctionTranslator(const FunctionTranslator&) = delete;
  FunctionTranslator& operator=(const FunctionTranslator&) = delete;

  /// False, and nothing was written, when there is no code for the overload.
  bool translate(Function function);

 protected:
  /// `call` writes the call itself; it and the instruction outlive this.
  FunctionTranslator(const Instruction& instruction, const FunctionRow& row, const std::function<void()>& call);
  virtual ~FunctionTranslator() = default;

  virtual void select() = 0;
  /// The least or the greatest; of those that are equal, or no numbers, the first.
  virtual void extreme(bool least) = 0;
  /// LIMIT(MN, IN, MX) is MIN(MAX(IN, MN), MX).
  virtual void limit() = 0;
  virtual void absolute() = 0;
  virtual void square_root() = 0;
  virtual void invert() = 0;
  /// By less than the width.
  virtual void shift(bool left) = 0;
  /// By what is not negative.
  virtual void rotate(bool left) = 0;
  /// False as of translate().
  virtual bool convert() = 0;

  [[nodiscard]] std::uint32_t argument(std::uint32_t n) const { return words_[5 + n]; }
  [[nodiscard]] std::uint32_t count() const { return words_[3]; }  ///< of arguments
  [[nodiscard]] std::uint32_t result() const { return words_[4]; }

  const std::uint32_t* words_;
  const stdlib::Overload& overload_;
  const std::function<void()>& call_;
  Type type_;  ///< of the row
  unsigned bytes_;
};

}  // namespace plc::native
