#include "drawings/make.h"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "drawings/sheet.h"
#include "drawings/statements.h"
#include "frontend-sfc/macro_steps.h"

namespace plc::drawings {
namespace {

using bytecode::Drawings;
using bytecode::DrawnBody;
using bytecode::DrawnLanguage;
using bytecode::DrawnOwner;

DrawnLanguage language_of(plcopen::Language language) {
  switch (language) {
    case plcopen::Language::kNone:
    case plcopen::Language::kLd:
      return DrawnLanguage::kLd;
    case plcopen::Language::kFbd:
      return DrawnLanguage::kFbd;
    case plcopen::Language::kSt:
      return DrawnLanguage::kSt;
    case plcopen::Language::kIl:
      return DrawnLanguage::kIl;
    case plcopen::Language::kSfc:
      return DrawnLanguage::kSfc;
  }
  return DrawnLanguage::kLd;
}

/// localIds that elements in macro steps have in the whole chart, by their places in the file.
using Renumbered = std::map<std::tuple<std::uint32_t, std::uint32_t, ElementKind>, std::int64_t>;

Renumbered ids_of_whole_chart(const plcopen::Body& body) {
  Renumbered ids;
  if (!sfc::has_macro_steps(body)) return ids;
  core::Diagnostics quiet;
  for (const plcopen::Element& e : sfc::expand_macro_steps(body, {}, quiet).elements) {
    ids.emplace(std::tuple(e.at.line, e.at.column, e.kind), e.at.local_id);
  }
  return ids;
}

class BodyMaker {
 public:
  BodyMaker(const std::string& name, bool has_plane) : has_plane_(has_plane) { out_.name = name; }

  DrawnBody make(const plcopen::Body& body, DrawnOwner owner, const core::Diagnostics& places) {
    out_.owner = owner;
    out_.worksheet = body.name;
    out_.language = language_of(body.language);
    out_.file = body.at.file < places.file_count() ? places.file_name(body.at.file) : "";
    const bool text = body.elements.empty() && !body.text.empty();
    if (text) {
      const core::SourceRef& text_at = body.text_at.line != 0 ? body.text_at : body.at;
      const core::SourceRef& at = body.lead.empty() ? text_at : body.lead_at;
      out_.text = body.lead + body.text;
      out_.text_line = at.line;
      out_.text_column = at.column;
      if (body.language != plcopen::Language::kSfc) out_.statements = statements_of(body, places);
    }
    if (body.language == plcopen::Language::kSfc && text) {
      core::Diagnostics quiet;
      Sheet sheet = read_chart_sheet(body, quiet);
      lay_out_chart(sheet);
      join(std::move(sheet), out_.name, {});
    } else if (!body.elements.empty() || !body.comments.empty()) {
      add_sheet(body, out_.name, ids_of_whole_chart(body));
    }
    return std::move(out_);
  }

 private:
  void add_sheet(const plcopen::Body& body, const std::string& caption, const Renumbered& ids) {
    Sheet sheet = read_sheet(body, has_plane_);
    if (!keep_places(sheet)) {
      body.language == plcopen::Language::kSfc ? lay_out_chart(sheet) : lay_out_networks(sheet);
    }
    const std::size_t first = join(std::move(sheet), caption, ids);
    for (std::size_t i = 0; i < body.elements.size(); ++i) {
      const plcopen::Element& e = body.elements[i];
      if (e.kind != ElementKind::kMacroStep || e.chart == nullptr || e.chart->macro == nullptr) continue;
      out_.elements[first + i].macro_sheet = static_cast<std::uint16_t>(out_.sheets.size());
      add_sheet(*e.chart->macro, e.text, ids);
    }
  }

  /// Adds a sheet below those that are there. Returns the index of its first element.
  std::size_t join(Sheet sheet, const std::string& caption, const Renumbered& ids) {
    const auto index = static_cast<std::uint16_t>(out_.sheets.size());
    out_.sheets.push_back(caption);
    const auto first = static_cast<std::uint32_t>(out_.elements.size());
    move(sheet, corner_of(sheet));
    for (DrawnElement& e : sheet.elements) {
      e.sheet = index;
      const auto changed = ids.find({e.line, e.column, e.kind});
      if (changed != ids.end()) e.local_id = changed->second;
      out_.elements.push_back(std::move(e));
    }
    for (DrawnWire& wire : sheet.wires) {
      wire.from += first;
      wire.to += first;
      out_.wires.push_back(std::move(wire));
    }
    for (DrawnComment& comment : sheet.comments) {
      comment.sheet = index;
      out_.comments.push_back(std::move(comment));
    }
    bottom_ = bottom_of(first);
    return first;
  }

  /// The left upper corner of all that a sheet shows, texts beside boxes included.
  static DrawnPoint corner_of(const Sheet& sheet) {
    DrawnPoint corner{bytecode::kMaxDrawn, bytecode::kMaxDrawn};
    const auto reach = [&](std::int32_t x, std::int32_t y) {
      corner.x = std::min(corner.x, x);
      corner.y = std::min(corner.y, y);
    };
    for (const DrawnElement& e : sheet.elements) {
      const Pads pads = pads_of(e);
      reach(e.x - pads.left, e.y - pads.top);
    }
    for (const DrawnWire& wire : sheet.wires) {
      for (const DrawnPoint& point : wire.points) reach(point.x, point.y);
    }
    for (const DrawnComment& comment : sheet.comments) reach(comment.x, comment.y);
    return corner;
  }

  void move(Sheet& sheet, DrawnPoint corner) const {
    const std::int32_t dx = kMargin - corner.x,
                       dy = (out_.sheets.size() > 1 ? bottom_ + kMargin : 0) + kMargin - corner.y;
    const auto by = [&](std::int32_t& x, std::int32_t& y) {
      x = std::clamp(x + dx, std::int32_t{0}, bytecode::kMaxDrawn);
      y = std::clamp(y + dy, std::int32_t{0}, bytecode::kMaxDrawn);
    };
    for (DrawnElement& e : sheet.elements) {
      by(e.x, e.y);
      for (DrawnPin& pin : e.pins) by(pin.at.x, pin.at.y);
    }
    for (DrawnWire& wire : sheet.wires) {
      for (DrawnPoint& point : wire.points) by(point.x, point.y);
    }
    for (DrawnComment& comment : sheet.comments) by(comment.x, comment.y);
  }

  [[nodiscard]] std::int32_t bottom_of(std::uint32_t first) const {
    std::int32_t bottom = bottom_;
    for (std::size_t i = first; i < out_.elements.size(); ++i) {
      bottom = std::max(bottom, out_.elements[i].y + out_.elements[i].height + pads_of(out_.elements[i]).bottom);
    }
    for (const DrawnWire& wire : out_.wires) {
      for (const DrawnPoint& point : wire.points) bottom = std::max(bottom, point.y);
    }
    return bottom;
  }

  bool has_plane_;
  DrawnBody out_;
  std::int32_t bottom_ = 0;
};

}  // namespace

std::vector<DrawnBody> make_bodies(const plcopen::Pou& pou, const std::string& name, DrawnOwner owner, bool has_plane,
                                   const core::Diagnostics& places) {
  std::vector<DrawnBody> bodies;
  for (const plcopen::Body& body : pou.bodies) {
    if (body.language == plcopen::Language::kNone) continue;
    bodies.push_back(BodyMaker(name, has_plane).make(body, owner, places));
  }
  return bodies;
}

std::string part_name(const plcopen::Pou& pou, const plcopen::Pou& part) { return pou.name + "." + part.name; }

DrawnOwner owner_of(plcopen::PouKind kind) {
  switch (kind) {
    case plcopen::PouKind::kProgram:
      return DrawnOwner::kProgram;
    case plcopen::PouKind::kFunctionBlock:
      return DrawnOwner::kFunctionBlock;
    case plcopen::PouKind::kFunction:
      return DrawnOwner::kFunction;
  }
  return DrawnOwner::kProgram;
}

Drawings make(const plcopen::Project& project, const core::Diagnostics& places) {
  Drawings drawings;
  const bool plane = project.version != plcopen::Version::kIec61131_10;
  const auto add = [&](const plcopen::Pou& pou, std::string name, DrawnOwner owner) {
    for (DrawnBody& body : make_bodies(pou, std::move(name), owner, plane, places)) {
      drawings.bodies.push_back(std::move(body));
    }
  };
  for (const plcopen::Pou& pou : project.pous) {
    add(pou, pou.name, owner_of(pou.kind));
    for (const plcopen::Pou& action : pou.actions) add(action, part_name(pou, action), DrawnOwner::kAction);
    for (const plcopen::Pou& transition : pou.transitions) {
      add(transition, part_name(pou, transition), DrawnOwner::kTransition);
    }
  }
  return drawings;
}

}  // namespace plc::drawings
