// The bytes of a project file as one zero-terminated UTF-8 buffer, and places in it.
//
// In: a path or bytes in UTF-8, UTF-16, ISO 8859-1 or Windows-1252, with or without byte order mark. Out: UTF-8 text
// that is safe to hand to the XML parser: no zero byte, no internal DTD subset, no tag with an absurd number of
// attributes. Does not belong here: XML events (xml_stream.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "plcopen/reader.h"

namespace plc::plcopen {

/// 1-based; `column` counts characters, not bytes.
struct Place {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
};

/// Turns byte offsets into places. Offsets asked in ascending order cost O(file) altogether, whatever the line lengths;
/// an offset before the last one is counted again from the mark, or from the start of the file.
class PlaceFinder {
 public:
  explicit PlaceFinder(std::string_view text) : text_(text) {}
  Place at(std::size_t offset);
  /// The same; what is asked for next may lie anywhere after it.
  Place mark(std::size_t offset);

 private:
  std::string_view text_;
  std::size_t offset_ = 0;
  Place place_;
  std::size_t marked_offset_ = 0;
  Place marked_;
};

/// Owns the text. The byte after the last one is zero, as libxml2 wants it of a buffer it does not copy.
class InputText {
 public:
  /// Null after reporting P1001, P1005, P1006 or P1014 for `file`.
  static std::unique_ptr<InputText> from_file(const std::string& path, std::uint16_t file,
                                              core::Diagnostics& diagnostics, const ReadLimits& limits);
  static std::unique_ptr<InputText> from_memory(std::string_view bytes, std::uint16_t file,
                                                core::Diagnostics& diagnostics, const ReadLimits& limits);

  [[nodiscard]] std::string_view text() const { return {bytes_.get() + begin_, size_ - begin_}; }

 private:
  InputText() = default;
  bool allocate(std::size_t size);
  bool normalise(std::uint16_t file, core::Diagnostics& diagnostics, const ReadLimits& limits);
  bool check_markup(std::uint16_t file, core::Diagnostics& diagnostics, const ReadLimits& limits) const;

  std::unique_ptr<char[]> bytes_;
  std::size_t size_ = 0;
  std::size_t begin_ = 0;  ///< after the byte order mark
};

}  // namespace plc::plcopen
