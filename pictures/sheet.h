// Sheet: the bodies of a POU on one plane, drawn in parts, for a viewer that shows what is in view and fills in values.
//
// In: bodies, marks with numbers. Out: SVG without a frame, whose elements carry the numbers of their marks ("data-k"),
// and names by which something is selected ("data-name", "data-type"); classes but no style. Threads: one, or several
// that only draw. Does not belong here: where values come from.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pictures/picture.h"

namespace plc::pictures {

class Sheet {
 public:
  /// The drawings of the bodies outlive it. Marks without a number (Mark::id) are drawn as in a picture.
  Sheet(std::span<const PicturedBody> bodies, Marks marks);
  ~Sheet();
  Sheet(const Sheet&) = delete;
  Sheet& operator=(const Sheet&) = delete;

  /// Pixels, in each direction.
  [[nodiscard]] std::int32_t width() const;
  [[nodiscard]] std::int32_t height() const;

  struct Part {
    std::string svg;           ///< well-formed pieces, which may reach out of the rectangle
    std::size_t left_out = 0;  ///< pieces that are not drawn, since there are more than `most`
  };
  /// What touches the rectangle. Texts are cut to 500 bytes.
  [[nodiscard]] Part draw(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height,
                          std::size_t most) const;
  struct Place {
    std::int32_t x = 0, y = 0, width = 0, height = 0;
  };
  /// Where an element of the body (as many as were given) is, or a line of its text, from 0; nothing: it has none.
  [[nodiscard]] std::optional<Place> place_of(std::size_t body, std::size_t element) const;
  /// Heights at which a page may end: nothing is cut there. Ascending.
  [[nodiscard]] std::vector<std::int32_t> breaks() const;

 private:
  struct Contents;
  std::unique_ptr<Contents> contents_;
};

}  // namespace plc::pictures
