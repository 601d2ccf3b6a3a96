// HmiPages: the HMI pages of the project that runs: pages.toml in its folder, and what it lets operators write.
//
// In: the folder, variables. Out: the document with its version; refusals of writes. A file that cannot be used leaves
// the pages of before; at the start: none, and nothing is offered. Without a file nothing is limited (docs/adr/0064).
// Threads: read(), save(), picture() block on the disk; the rest at once; all any. Does not belong here: the form of
// the file (hmi/), JSON, how pages look.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "engineering/variables.h"
#include "hmi/document.h"

namespace plc::engineering {

/// What pages let operators write, and where that is.
struct HmiOffer {
  hmi::Offer offer;
  runtime::Place place;
};
/// Where the pages of a project are: beside its file, in its folder; empty without a project.
std::string pages_file(const std::string& project);
/// The offers of a document whose variables are there, by their places. P7776 for what is not there.
std::vector<HmiOffer> offers_of_pages(const hmi::Document& document, Variables& variables,
                                      core::Diagnostics& diagnostics);

/// Pages as they were read.
struct HmiState {
  bool there = false;   ///< there is a file
  std::string version;  ///< of its bytes; empty without a file
  hmi::Document document;
  std::vector<core::Diagnostic> problems;  ///< of the newest file
  std::vector<std::string> texts;          ///< the same as "pages.toml:3:1: error .."
  std::vector<HmiOffer> offers;            ///< by their places
  /// Those of the variable at this place of the global table.
  [[nodiscard]] std::span<const HmiOffer> at(std::uint32_t offset) const;
  bool usable = true;  ///< the newest file has no error
};

class HmiPages {
 public:
  /// `project`: file or folder that runs; empty: there are no pages and none can be saved.
  HmiPages(const std::string& project, Variables& variables);

  /// Reads the file where it has changed since the last time.
  void read();
  [[nodiscard]] std::shared_ptr<const HmiState> state() const;
  /// Replaces the file, when `version` is that of the present one. P7778; P7770 to P7775 when the document is wrong,
  /// with what is wrong in `field`: "pages[0].elements[2].low"; P7779 when the file is no document or cannot be
  /// written.
  std::optional<core::Problem> save(const std::string& version, const hmi::Document& document, std::string& field);

  /// Whether pages offer these writes to operators: each of them, with this value. P7777.
  [[nodiscard]] std::optional<core::Problem> refusal(std::span<const Variables::Write> writes) const;
  /// Whether a button holds this variable. P7777.
  [[nodiscard]] std::optional<core::Problem> press_refusal(std::string_view path) const;

  struct Picture {
    std::string bytes;
    std::string_view type;  ///< "image/png"
  };
  /// A picture beside pages.toml. P7780.
  core::Result<Picture> picture(const std::string& name) const;

 private:
  [[nodiscard]] std::shared_ptr<HmiState> parsed(bool there, std::string text) const;

  std::string file_;  ///< empty: none
  Variables& variables_;
  std::mutex reading_;        ///< one reads or saves at a time
  mutable std::mutex mutex_;  ///< of state_
  std::shared_ptr<const HmiState> state_;
};

}  // namespace plc::engineering
