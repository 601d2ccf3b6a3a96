// CodeWriter: appends instructions and look-up records to a body, keeps one BOOL_RUN open as long as only records come
// (dispatch is paid per run), resolves jumps, notes sources. In: words. Out: ImagePou::code and ::debug.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "bytecode/codegen/analysis.h"
#include "bytecode/codegen/boolean_map.h"
#include "bytecode/image.h"

namespace plc::bytecode {

class CodeWriter {
 public:
  CodeWriter(std::vector<std::uint32_t>& code, std::vector<DebugEntry>& debug) : code_(code), debug_(debug) {}

  /// What follows comes from `at`.
  void source(const core::SourceRef& at) { at_ = &at; }

  void op(Opcode opcode, std::initializer_list<std::uint32_t> words, std::span<const std::uint32_t> list = {},
          std::uint32_t list_items = 0) {
    close_run();
    note();
    code_.push_back(opcode_word(opcode, list_items));
    code_.insert(code_.end(), words);
    code_.insert(code_.end(), list.begin(), list.end());
  }

  /// One look-up record: out := piece.
  void record(std::uint32_t out, const Piece& piece) {
    if (run_ == kUnset || records_ == kMaxListItems) {
      close_run();
      run_ = static_cast<std::uint32_t>(code_.size());
      note();
      code_.push_back(0);
    } else {
      note();
    }
    ++records_;
    const std::uint32_t fill = piece.count == 0 ? out : piece.leaf[0];
    std::uint32_t words[kRecordWords] = {piece.table, out, fill, fill, fill, fill, fill};
    for (std::uint32_t k = 0; k < piece.count; ++k) words[2 + k] = piece.leaf[k];
    code_.insert(code_.end(), words, words + kRecordWords);
  }

  /// The place after what was written so far, as the start of an instruction.
  std::uint32_t here() {
    close_run();
    return static_cast<std::uint32_t>(code_.size());
  }
  /// Index of the word written last: a jump target to be set with patch().
  [[nodiscard]] std::uint32_t last_word() const { return static_cast<std::uint32_t>(code_.size() - 1); }
  void patch(std::uint32_t word, std::uint32_t target) { code_[word] = target; }

 private:
  void close_run() {
    if (run_ == kUnset) return;
    code_[run_] = opcode_word(Opcode::kBoolRun, records_);
    run_ = kUnset;
    records_ = 0;
  }
  void note() {
    if (at_ == nullptr || (!debug_.empty() && debug_.back().at == *at_)) return;
    const auto word = static_cast<std::uint32_t>(code_.size());
    if (!debug_.empty() && debug_.back().word == word) {
      debug_.back().at = *at_;
    } else {
      debug_.push_back({word, *at_});
    }
  }

  std::vector<std::uint32_t>& code_;
  std::vector<DebugEntry>& debug_;
  const core::SourceRef* at_ = nullptr;
  std::uint32_t run_ = kUnset;
  std::uint32_t records_ = 0;
};

}  // namespace plc::bytecode
