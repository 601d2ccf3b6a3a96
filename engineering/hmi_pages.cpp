#include "engineering/hmi_pages.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/text.h"
#include "engineering/secrets.h"
#include "engineering/state_files.h"
#include "engineering/value_json.h"

namespace plc::engineering {
namespace {

using core::Code;
using core::Problem;
using hmi::Offer;
namespace fs = std::filesystem;

constexpr const char* kName = "pages.toml";
constexpr off_t kMostPictureBytes = 5'000'000;

struct PictureType {
  std::string_view ending, type, begin;
};
/// How files of a type begin; of SVG, which is text, it is not asked.
constexpr PictureType kPictures[] = {
    {".png", "image/png", "\x89PNG\r\n"},    {".jpg", "image/jpeg", "\xff\xd8\xff"},
    {".jpeg", "image/jpeg", "\xff\xd8\xff"}, {".gif", "image/gif", "GIF8"},
    {".webp", "image/webp", "RIFF"},         {".svg", "image/svg+xml", ""},
};

/// The number that bytes of a type are, of durations the seconds; nothing of those that are none.
std::optional<double> number_of(const bytecode::Image& image, std::uint32_t type, const std::byte* bytes) {
  const auto& declared = image.types[type];
  if (declared.kind == bytecode::TypeKind::kScalar && core::in_category(declared.elementary, core::kAnyDuration)) {
    std::int64_t ns = 0;
    std::memcpy(&ns, bytes, sizeof ns);
    return static_cast<double>(ns) / 1e9;
  }
  const Json value = value_json(image, type, bytes);
  if (value.is_number()) return value.get<double>();
  // Numbers of 64 bits are texts.
  const auto* const scalar = value.is_string() ? &value.get_ref<const std::string&>() : nullptr;
  if (scalar == nullptr || declared.kind != bytecode::TypeKind::kScalar || !declared.members.empty())
    return std::nullopt;
  char* end = nullptr;
  const double number = std::strtod(scalar->c_str(), &end);
  return scalar->empty() || *end != '\0' ? std::nullopt : std::optional(number);
}

Json json_of(const hmi::Value& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag;
  if (const auto* number = std::get_if<double>(&value)) return *number;
  if (const auto* text = std::get_if<std::string>(&value)) return *text;
  return nullptr;
}

bool allows(const bytecode::Image& image, const HmiOffer& offered, const Variables::Write& write) {
  const Offer& offer = offered.offer;
  if (offered.place.offset != write.offset || offered.place.type != write.type) return false;
  switch (offer.way) {
    case Offer::Way::kAny:
      return true;
    case Offer::Way::kPress:
      return false;
    case Offer::Way::kValue: {
      std::vector<LeafValue> leaves;
      std::string field;
      Json value = json_of(offer.value);
      // Whole numbers of the file are numbers with a fraction here.
      if (const auto* number = std::get_if<double>(&offer.value);
          number != nullptr && *number == std::floor(*number) && std::abs(*number) < 9e15)
        value = static_cast<std::int64_t>(*number);
      if (leaves_of(image, write.type, value, 0, leaves, field) || leaves.size() != 1) return false;
      return leaves[0].bytes == write.bytes;
    }
    case Offer::Way::kRange:
      break;
  }
  if (!offer.low && !offer.high) return true;
  const std::optional<double> number = number_of(image, write.type, write.bytes.data());
  return number && *number >= offer.low.value_or(*number) && *number <= offer.high.value_or(*number);
}

std::string limits_text(const Offer& offer) {
  if (offer.low && offer.high) return fmt::format("from {} to {}", *offer.low, *offer.high);
  return offer.low ? fmt::format("at least {}", *offer.low) : fmt::format("at most {}", offer.high.value_or(0));
}

}  // namespace

std::string pages_file(const std::string& project) {
  if (project.empty()) return {};
  std::error_code error;
  const fs::path path(project);
  return (fs::is_directory(path, error) ? path : path.parent_path()) / kName;
}

std::vector<HmiOffer> offers_of_pages(const hmi::Document& document, Variables& variables,
                                      core::Diagnostics& diagnostics) {
  std::vector<HmiOffer> offers;
  const runtime::Access access(variables.resource());
  const auto find = [&](std::string_view path, const core::SourceRef& at) -> std::optional<runtime::Place> {
    if (path.empty()) return std::nullopt;
    auto place = access.find(path);
    if (place) return *place;
    diagnostics.report(Code::P7776, at, {}, place.error().message, place.error().help);
    return std::nullopt;
  };
  for (const hmi::Page& page : document.pages) {
    for (const hmi::Element& element : page.elements) {
      const auto* const plotted = std::get_if<std::vector<std::string>>(&element.values[hmi::key("variables")]);
      for (const std::string& path : plotted == nullptr ? std::vector<std::string>() : *plotted)
        find(path, element.place(hmi::key("variables")));
      // Of those that write, the offers tell.
      if (row_of(element.kind).use != hmi::Use::kWrites && !element.is_true(hmi::key("entered"))) {
        find(element.text(hmi::key("variable")), element.place(hmi::key("variable")));
      }
    }
  }
  for (hmi::Offer& offer : hmi::offers_of(document)) {
    const auto place = find(offer.path, offer.at);
    if (!place) continue;
    if (!variables.is_writable(*place)) {
      diagnostics.report(Code::P7776, offer.at, {}, fmt::format("\"{}\" cannot be written", offer.path),
                         "a constant, an input of a driver, or a variable of a program");
      continue;
    }
    if ((offer.way == Offer::Way::kAny || offer.way == Offer::Way::kPress) &&
        type_name(variables.image(), place->type) != "BOOL") {
      diagnostics.report(Code::P7776, offer.at, {}, fmt::format("\"{}\" is no BOOL", offer.path));
      continue;
    }
    offers.push_back({std::move(offer), *place});
  }
  std::stable_sort(offers.begin(), offers.end(),
                   [](const auto& one, const auto& other) { return one.place.offset < other.place.offset; });
  return offers;
}

std::span<const HmiOffer> HmiState::at(std::uint32_t offset) const {
  const auto begin =
      std::lower_bound(offers.begin(), offers.end(), offset,
                       [](const HmiOffer& one, std::uint32_t wanted) { return one.place.offset < wanted; });
  auto end = begin;
  while (end != offers.end() && end->place.offset == offset) ++end;
  return {begin, end};
}

HmiPages::HmiPages(const std::string& project, Variables& variables)
    : file_(pages_file(project)), variables_(variables), state_(std::make_shared<HmiState>()) {}

std::shared_ptr<const HmiState> HmiPages::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

std::shared_ptr<HmiState> HmiPages::parsed(bool there, std::string text) const {
  auto fresh = std::make_shared<HmiState>();
  fresh->there = there;
  if (!there) return fresh;
  fresh->version = sha256(text).substr(0, 16);
  core::Diagnostics diagnostics;
  if (auto document = hmi::read_document(text, kName, diagnostics)) {
    fresh->document = std::move(*document);
  } else {
    fresh->usable = false;
    const auto before = state();
    fresh->document = before->document;
  }
  core::Diagnostics ignored;
  fresh->offers = offers_of_pages(fresh->document, variables_, fresh->usable ? diagnostics : ignored);
  fresh->problems = diagnostics.all();
  for (const core::Diagnostic& one : fresh->problems) {
    std::string line = diagnostics.render_one(one);
    line.resize(std::min(line.find('\n'), line.size()));
    if (!one.help.empty()) line += " (" + one.help + ")";
    fresh->texts.push_back(std::move(line));
  }
  return fresh;
}

void HmiPages::read() {
  if (file_.empty()) return;
  const std::lock_guard reading(reading_);
  std::string why;
  std::optional<std::string> text = read_whole_file(file_, why);
  std::shared_ptr<HmiState> fresh;
  if (!why.empty()) {
    fresh = std::make_shared<HmiState>(*state());
    fresh->there = true;
    fresh->usable = false;
    fresh->version = "unreadable";
    fresh->problems = {{Code::P7779, core::Severity::kError, {}, {}, why, {}}};
    fresh->texts = {"error P7779: " + why};
  } else {
    const auto before = state();
    if (text.has_value() == before->there && (!text || sha256(*text).substr(0, 16) == before->version)) return;
    fresh = parsed(text.has_value(), text.value_or(""));
  }
  const std::lock_guard lock(mutex_);
  state_ = std::move(fresh);
}

std::optional<Problem> HmiPages::save(const std::string& version, const hmi::Document& document, std::string& field) {
  if (file_.empty()) {
    return Problem{Code::P7779, "the program has no folder in which pages could be", {}};
  }
  read();
  const std::lock_guard reading(reading_);
  const auto before = state();
  if (before->version != version) {
    return Problem{
        Code::P7778, "pages.toml was changed since these pages were loaded",
        "load them again; the editor can keep a copy of what was edited, or save it over that of the others"};
  }
  if (!before->usable) {
    return Problem{Code::P7779, "pages.toml has mistakes, and would be lost", "mend it, or remove it"};
  }
  std::string text = hmi::write_document(document);
  core::Diagnostics diagnostics;
  if (!hmi::read_document(text, kName, diagnostics)) {
    const auto& all = diagnostics.all();
    const auto error =
        std::find_if(all.begin(), all.end(), [](const auto& one) { return one.severity == core::Severity::kError; });
    if (std::string found = hmi::field_of_line(text, error->at.line); !found.empty()) field = std::move(found);
    return Problem{error->code, error->message, error->help};
  }
  struct stat status {};
  const mode_t mode = ::stat(file_.c_str(), &status) == 0 ? status.st_mode & 0777 : 0644;
  if (const std::string why = write_file(file_, text, mode); !why.empty()) {
    return Problem{Code::P7779, why, "does the folder of the project belong to the user of plc-run?"};
  }
  auto fresh = parsed(true, std::move(text));
  const std::lock_guard lock(mutex_);
  state_ = std::move(fresh);
  return std::nullopt;
}

std::optional<Problem> HmiPages::refusal(std::span<const Variables::Write> writes) const {
  const auto now = state();
  if (!now->there) return std::nullopt;
  for (const Variables::Write& write : writes) {
    const HmiOffer* near = nullptr;
    bool allowed = false;
    for (const HmiOffer& offered : now->at(write.offset)) {
      allowed = allowed || allows(variables_.image(), offered, write);
      if (offered.offer.way == Offer::Way::kRange) near = &offered;
    }
    if (allowed) continue;
    if (near != nullptr) {
      return Problem{Code::P7777, fmt::format("\"{}\" may be {}", near->offer.path, limits_text(near->offer)),
                     "pages.toml has the limits"};
    }
    return Problem{Code::P7777, "no page offers this to operators", "an engineer adds it to pages.toml"};
  }
  return std::nullopt;
}

std::optional<Problem> HmiPages::press_refusal(std::string_view path) const {
  const auto now = state();
  if (!now->there) return std::nullopt;
  const auto place = runtime::Access(variables_.resource()).find(path);
  if (place && place->task == runtime::Place::kGlobal) {
    for (const HmiOffer& offered : now->at(place->offset)) {
      if (offered.offer.way == Offer::Way::kPress && offered.place.type == place->type) return std::nullopt;
    }
  }
  return Problem{Code::P7777, fmt::format("no button of a page holds \"{}\"", path),
                 "an engineer adds one to pages.toml"};
}

core::Result<HmiPages::Picture> HmiPages::picture(const std::string& name) const {
  const auto refuse = [&](std::string why) { return Problem{Code::P7780, "\"" + name + "\" " + std::move(why), {}}; };
  const std::string folded = core::folded(name);
  const auto* const type = std::find_if(std::begin(kPictures), std::end(kPictures),
                                        [&](const PictureType& one) { return folded.ends_with(one.ending); });
  if (file_.empty() || type == std::end(kPictures) || name.front() == '.' ||
      name.find_first_of(std::string_view("/\\\0", 3)) != std::string::npos) {
    return refuse("is no name of a picture beside pages.toml");
  }
  const int file =
      ::open((fs::path(file_).parent_path() / name).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file < 0) return refuse(std::string("cannot be read: ") + std::strerror(errno));
  struct stat status {};
  std::string bytes;
  const bool good = ::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && status.st_size <= kMostPictureBytes;
  if (good) {
    bytes.resize(static_cast<std::size_t>(status.st_size));
    std::size_t had = 0;
    for (ssize_t more = 1; had < bytes.size() && more > 0; had += static_cast<std::size_t>(std::max<ssize_t>(more, 0)))
      more = ::read(file, bytes.data() + had, bytes.size() - had);
    bytes.resize(had);
  }
  ::close(file);
  if (!good) return refuse("is no file, or has more than 5 MB");
  if (!bytes.starts_with(type->begin)) return refuse("is no picture of this type");
  return Picture{std::move(bytes), type->type};
}

}  // namespace plc::engineering
