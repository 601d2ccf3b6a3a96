// Result<T>: a value or a coded problem, for set-up code (files, images, drivers) that cannot go on. A small subset of
// std::expected, which this compiler does not have. Compiler steps use Diagnostics& instead and go on to find more.
#pragma once

#include <string>
#include <utility>
#include <variant>

#include "core/diagnostics.h"

namespace plc::core {

struct Problem {
  Code code;
  std::string message;
  std::string help;
  std::string path = {};  ///< of the variable that it is about, as runtime/access.h spells it; or empty
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Problem problem) : state_(std::in_place_index<1>, std::move(problem)) {}

  [[nodiscard]] bool has_value() const { return state_.index() == 0; }
  explicit operator bool() const { return has_value(); }
  T& value() { return std::get<0>(state_); }
  const T& value() const { return std::get<0>(state_); }
  T& operator*() { return value(); }
  const T& operator*() const { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  [[nodiscard]] const Problem& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Problem> state_;
};

}  // namespace plc::core
