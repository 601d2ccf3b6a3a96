#include "native/emitter.h"

#include <cstring>

#include "native/helpers.h"

namespace plc::native {

Emitter::Emitter(asmjit::BaseAssembler& assembler, const Memory& memory, std::size_t reach)
    : table_(reinterpret_cast<std::uint64_t>(memory.table)), memory_(memory), assembler_(assembler), reach_(reach) {
  code_.init(asmjit::Environment::host());
  code_.setErrorHandler(this);
}

void Emitter::attach() { code_.attach(&assembler_); }

void Emitter::handleError(asmjit::Error, const char* message, asmjit::BaseEmitter*) { refuse(message); }

std::optional<std::uint64_t> Emitter::constant(std::uint32_t operand, unsigned bytes) const {
  if (operand < memory_.constants || operand >= memory_.constants_end) return std::nullopt;
  std::uint64_t value = 0;
  std::memcpy(&value, memory_.table + operand, bytes);
  return value;
}

void Emitter::cold_path(std::function<void()> code) {
  if (cold_paths_.empty()) first_cold_path_ = size();
  cold_paths_.push_back({std::move(code), kept_, missing_});
}

void Emitter::keep_cold_paths_near() {
  if (cold_paths_.empty() || size() - first_cold_path_ < reach_) return;
  const asmjit::Label after = label();
  jump(after);
  write_cold_paths();
  land(after);
}

void Emitter::write_cold_paths() {
  // Index by index: what is written may put more aside.
  for (std::size_t i = 0; i < cold_paths_.size(); ++i) {
    const ColdPath aside = std::move(cold_paths_[i]);
    kept_ = aside.kept;
    missing_ = aside.missing;
    aside.code();
  }
  kept_.reset();
  missing_.reset();
  cold_paths_.clear();
  forget();
}

void Emitter::raise(std::uint32_t position, int event) {
  if (event < 0) {
    pass_result(2);
  } else {
    pass(2, static_cast<std::uint64_t>(event));
  }
  pass(1, position);
  pass_machine(0);
  call(&raise_event);
}

asmjit::Label Emitter::data(std::vector<std::uint64_t> words) {
  const asmjit::Label label = assembler_.newLabel();
  data_.emplace_back(label, std::move(words));
  return label;
}

void Emitter::write_data() {
  assembler_.align(asmjit::AlignMode::kData, 8);
  for (const auto& [label, words] : data_) {
    assembler_.bind(label);
    assembler_.embed(words.data(), words.size() * sizeof(std::uint64_t));
  }
}

std::size_t Emitter::finish() {
  code_.flatten();
  code_.resolveUnresolvedLinks();
  return code_.codeSize();
}

bool Emitter::write(std::span<std::byte> to, std::uint64_t address) {
  if (code_.relocateToBase(address) == asmjit::kErrorRelocOffsetOutOfRange) return false;
  code_.copyFlattenedData(to.data(), to.size());
  return true;
}

}  // namespace plc::native
