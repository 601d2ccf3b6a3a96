// How inputs change before each scan, in the same way for every side.
//
// In: a Source, and where each side has its variables. Out: values in them. Does not belong here: scanning and timing
// (scan.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "bench/side.h"
#include "bench/workload.h"

namespace plc::bench {

/// The inputs of one side. Cheap, since the time is measured with the scan: what all inputs get is made beforehand, and
/// copied at once where they lie side by side, as they do in C and in PICARD.
class InputWriter {
 public:
  InputWriter(const Source& source, const Side& side, Inputs inputs);
  /// Equal numbers of scans give equal values.
  void write(std::uint64_t scan) const {
    if (rows_.empty()) {
      write_one_of_each(scan);
    } else {
      write_all(scan);
    }
  }

 private:
  /// Bytes of a row and where they go.
  struct Part {
    unsigned char* to = nullptr;
    std::size_t from = 0, bytes = 0;
  };
  void make_rows(const Source& source, const Side& side);
  void write_one_of_each(std::uint64_t scan) const;
  void write_all(std::uint64_t scan) const;

  std::vector<unsigned char*> by_stimulus_[kStimulusCount];
  std::vector<unsigned char> rows_;  ///< random values of all inputs, again and again
  std::size_t row_bytes_ = 0, row_count_ = 0;
  std::vector<Part> parts_;
};

}  // namespace plc::bench
