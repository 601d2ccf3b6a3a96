// A file of TOML that is a few tables of keys: alarms.toml, historian.toml. It is checked as plc.toml is, by rows.
//
// In: text, rows. Out: the tables that are good, and what is wrong with the others. Does not belong here: what keys
// mean.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "io-drivers/config/key_values.h"

namespace plc::io {

/// A table that the file may have.
struct FileTable {
  std::string_view name;          ///< "alarm"
  std::span<const KeyInfo> keys;  ///< that outlive what is read
  bool many = false;              ///< [[alarm]], as often as one wants; else [historian], once
};

/// One that it has.
struct ReadTable {
  const FileTable* table = nullptr;
  core::SourceRef at;
  KeyValues values;
};

/// Reports what is wrong (P7301 to P7306) with line and column; a table with a problem is left out. Nothing when the
/// text is no TOML at all.
std::vector<ReadTable> read_table_file(std::string_view text, std::string_view file, std::span<const FileTable> tables,
                                       core::Diagnostics& diagnostics);
/// The text of a file of at most 4 MB; nothing when there is none, or when it cannot be read, which is reported
/// (P7001).
std::optional<std::string> table_file_text(const std::string& path, core::Diagnostics& diagnostics);

}  // namespace plc::io
