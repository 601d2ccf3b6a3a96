// What the tests of a project saw happen, as figures and as a list of what they did not.
//
// In: sites of a compilation, outcomes that were seen (Runner::seen), pragmas of the files. Out: totals for each POU,
// everything that was not seen with the reason that can be told. Does not belong here: pictures
// (tools/plc/coverage_svg.h).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "ir/coverage.h"
#include "plcopen/project.h"

namespace plc::tests {

/// {not_covered Main 'Stop' open 'the plant has no such state'}: in a file of tests, says why nothing shows an outcome.
struct Waiver {
  std::string pou;
  std::string element;  ///< text of the contact, coil or branch, or its localId
  std::string outcome;  ///< as in cover_kinds.def; empty = all
  std::string reason;
  core::SourceRef at;
  bool used = false;
};
/// The pragmas of this form; others are left alone.
std::vector<Waiver> waivers_of(const std::vector<plcopen::Pragma>& pragmas);

/// An outcome that no test has shown.
struct Unseen {
  std::uint32_t site = 0;
  std::string outcome;  ///< "open"
  std::string why;      ///< "always closed when power reached it"
  std::string reason;   ///< of a waiver, or empty
};

struct CoverageOfPou {
  std::string pou;
  struct Count {
    std::uint32_t seen = 0;
    std::uint32_t of = 0;
  };
  std::array<Count, ir::kCoverKinds> by_kind;  ///< outcomes
};

class CoverageReport {
 public:
  CoverageReport(std::vector<ir::CoverSite> sites, std::vector<bool> seen, std::vector<Waiver> waivers);

  [[nodiscard]] const std::vector<ir::CoverSite>& sites() const { return sites_; }
  [[nodiscard]] bool seen(std::uint32_t site, std::uint32_t outcome) const { return seen_[2 * site + outcome]; }
  /// True when every outcome of the site was seen.
  [[nodiscard]] bool complete(std::uint32_t site) const;
  [[nodiscard]] const std::vector<CoverageOfPou>& pous() const { return pous_; }
  [[nodiscard]] const std::vector<Unseen>& unseen() const { return unseen_; }
  /// Waivers of nothing: what they name was seen, or is not there.
  [[nodiscard]] std::vector<Waiver> idle_waivers() const;
  /// Outcomes of contacts that were not seen and have no waiver.
  [[nodiscard]] std::size_t open_contacts() const;

  /// The table of POUs and the list of what was not seen; `files` are the names of the compilation's.
  [[nodiscard]] std::string text(const std::vector<std::string>& files) const;

 private:
  std::vector<ir::CoverSite> sites_;
  std::vector<bool> seen_;
  std::vector<Waiver> waivers_;
  std::vector<CoverageOfPou> pous_;
  std::vector<Unseen> unseen_;
};

}  // namespace plc::tests
