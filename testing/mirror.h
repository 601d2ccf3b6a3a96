// Mirror: keeps the copies that a test has of the project's variables equal to them.
//
// In: the project's resource and that of the tests, made from one module. Out: pull() copies all globals and program
// instances of the project into the table of the tests' task; push() writes what the test changed since then into the
// project, as an operator would: globals that a task exports change at its next scan, variables of programs at once.
// References are not copied: what a reference in the tests' table would refer to is not there. Threads: one; between
// scans of the project. Does not belong here: when that happens (runner.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/tests.h"
#include "core/result.h"
#include "runtime/access.h"
#include "runtime/resource.h"

namespace plc::tests {

class Mirror {
 public:
  /// P9001 when the images do not fit.
  static core::Result<std::unique_ptr<Mirror>> make(runtime::Resource& project, runtime::Resource& tests,
                                                    const std::vector<std::string>& programs);

  void pull();
  /// Nothing, or the first value that could not be written (P7106, P7107).
  std::optional<core::Problem> push();

 private:
  /// Bytes that are equal in both tables.
  struct Run {
    std::uint32_t from = 0;  ///< in the copy of the project's table
    std::uint32_t to = 0;    ///< in the tests' table
    std::uint32_t bytes = 0;
  };
  /// A scalar or string.
  struct Leaf {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    std::uint32_t type = 0;  ///< of the project's image
    std::string path;        ///< in the project
  };
  struct Part {
    std::string path;
    runtime::Place place;  ///< in the project
    std::uint32_t to = 0;  ///< in the tests' table
    std::vector<Run> runs;
  };

  Mirror(runtime::Resource& project, runtime::Resource& tests) : project_(project), tests_(tests), access_(project) {}
  bool add(const std::string& path, const runtime::Place& place, const runtime::Place& copy);
  /// Adds the runs of a value of these types; false when they differ.
  bool add_runs(Part& part, std::uint32_t type, std::uint32_t copy_type, std::uint32_t from, std::uint32_t to) const;
  /// The leaves of a value of the project's `type` that differ between the two tables.
  void find_changes(const Part& part, std::uint32_t type, std::uint32_t offset, const std::string& path,
                    std::vector<Leaf>& changes) const;
  [[nodiscard]] std::byte* project_bytes(const Part& part);

  runtime::Resource& project_;
  runtime::Resource& tests_;
  runtime::Access access_;
  std::vector<Part> parts_;
  std::vector<std::byte> globals_;  ///< the project's global table, as pulled last
  std::vector<std::byte> seen_;     ///< the tests' table, as pulled last
};

}  // namespace plc::tests
