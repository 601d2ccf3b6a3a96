// Configuration: what plc.toml says about this machine: drivers, which variable is which channel, Modbus, guardian.
//
// In: TOML text (read_configuration.cpp, the only user of toml++). Out: plain data in which every entry knows its place
// in the file; nothing is resolved against a project yet (bind.h does that). Keys, their types, defaults and
// documentation are declared once, in config/keys.def and by the kinds of drivers; `plc config init`, the checker and
// docs/reference/configuration.md come from there. Does not belong here: devices, images.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "core/diagnostics.h"
#include "io-drivers/config/key_values.h"
#include "runtime/sched/task_plan.h"

namespace plc::io {

class Findings;

enum class OnLoss : std::uint8_t { kHold, kZero };  ///< inputs of a lost device: last value, or FALSE / 0

/// [drivers.NAME]
struct DriverConfig {
  std::string name;
  core::SourceRef at;
  const DriverType* type = nullptr;  ///< of `kind`; never null once the file was found good
  Placed task;                       ///< name of the task it serves; empty = the fastest
  OnLoss on_loss = OnLoss::kHold;
  core::TimeNs retry_ns = 1'000'000'000;  ///< between attempts to come back
  Placed ok;                              ///< BOOL global that is TRUE while the device answers, or empty
  KeyValues values;                       ///< of the kind's own keys
};

/// One line of [inputs] or [outputs]:  "%IX0.0" = { driver = "panel", channel = 17, invert = true }
struct ChannelConfig {
  Placed variable;  ///< address, global or path as the key has it
  Placed driver;
  Applies direction = kAlways;  ///< kInputsOnly or kOutputsOnly
  bool invert = false;          ///< TRUE in the program is FALSE at the device
  // outputs
  Placed safe;       ///< value at stop, fault, death; empty = FALSE / 0
  Placed initial;    ///< value from open() to the end of the first cycle; empty = safe
  KeyValues values;  ///< of the keys that the driver's kind has of its own
};

/// Which 16-bit word of a value comes first (and which byte in it): 123.456 = 42F6 E979 is ABCD.
enum class WordOrder : std::uint8_t { kAbcd, kCdab, kBadc, kDcba };
std::string_view word_order_text(WordOrder order);

enum class ModbusTable : std::uint8_t { kCoils, kDiscreteInputs, kInputRegisters, kHoldingRegisters };
/// "coils", "discrete-inputs", "input-registers", "holding-registers".
std::string_view modbus_table_text(ModbusTable table);

/// One [[modbus.range]]: what holds for addresses first..last of one table. Later ranges count before earlier ones.
struct ModbusRange {
  core::SourceRef at;
  ModbusTable table = ModbusTable::kHoldingRegisters;
  std::uint16_t first = 0;
  std::uint16_t last = 65535;
  std::optional<bool> writable;
  std::optional<WordOrder> word_order;
  std::optional<bool> latch;  ///< coils: a reset waits until the program has seen the coil set
};

/// [modbus.serial]
struct ModbusSerialConfig {
  core::SourceRef at;
  Placed path;
  Placed line = {"19200 8E1", {}};  ///< as modbus_rtu::parse_line() reads it
  std::uint8_t unit = 1;            ///< 1..247
};

/// [modbus]; the defaults are what plc-run does without a configuration.
struct ModbusConfig {
  core::SourceRef at;
  bool enabled = true;                ///< over TCP
  core::SourceRef listen_at;          ///< of `listen`; no line when it is not there
  std::string address = "127.0.0.1";  ///< to listen on; IPv4 or IPv6 literal
  std::uint16_t port = 502;           ///< 0 = any free one (tests)
  /// A TCP socket that listens already, in place of address and port; -1 = none. Its owner closes it.
  int socket = -1;
  bool read_only = false;        ///< writing functions are answered with exception 1
  std::vector<Placed> writable;  ///< path patterns that may be written; empty = everything writable in the map
  std::vector<Placed> exported = {{"*", {}}};  ///< path patterns of unlocated globals that get automatic addresses
  WordOrder word_order = WordOrder::kAbcd;
  std::vector<ModbusRange> ranges;
  bool strict_gaps = false;             ///< exception 2 for addresses without a variable, instead of 0
  std::optional<std::uint8_t> unit_id;  ///< answer only this one; nothing = all
  bool unit_exception = false;          ///< other unit ids: exception 11 instead of silence
  std::uint32_t max_clients = 64;
  std::uint32_t max_clients_per_address = 0;      ///< 0 = max_clients
  core::TimeNs frame_timeout_ns = 5'000'000'000;  ///< for the rest of a frame that has begun
  core::TimeNs idle_timeout_ns =
      0;               ///< connections without a request; 0 = never closed (TCP keep-alive finds dead ones)
  Placed lock_file;    ///< automatic addresses, relative to plc.toml; empty = beside the project: NAME.modbus.csv
  Placed client_seen;  ///< BOOL global: a request was answered within client_timeout_ns; empty = none
  core::TimeNs client_timeout_ns = 5'000'000'000;
  std::optional<ModbusSerialConfig> serial;

  /// Over TCP or a serial line.
  [[nodiscard]] bool serves() const { return enabled || serial; }
};

enum class Priorities : std::uint8_t { kProject, kRateMonotonic };
/// Outputs without a driver whose task a fault has stopped: last value, or the initial one.
enum class FaultOutputs : std::uint8_t { kHold, kSafe };
enum class Unfit : std::uint8_t { kRefuse, kRun };  ///< tasks that cannot meet their deadlines

/// [scheduler]
struct SchedulerConfig {
  core::SourceRef at;
  Priorities priorities = Priorities::kProject;
  std::optional<std::uint32_t> cpu;     ///< of tasks that name none; nothing = any
  core::SourceRef cpu_at;               ///< where `cpu` stands
  std::optional<core::TimeNs> lead_ns;  ///< of tasks with an interval that say nothing; nothing = by default
  Placed calibration;                   ///< file, relative to plc.toml; empty = built-in times
  Unfit unfit = Unfit::kRefuse;
  FaultOutputs outputs = FaultOutputs::kHold;
};

/// [tasks.NAME]
struct TaskConfig {
  std::string name;
  core::SourceRef at;
  std::optional<std::uint32_t> priority;  ///< 0 is the most urgent
  std::optional<std::uint32_t> cpu;
  core::SourceRef cpu_at;
  core::TimeNs offset_ns = 0;
  std::optional<core::TimeNs> lead_ns;       ///< nothing = as [scheduler] says
  std::optional<core::TimeNs> deadline_ns;   ///< nothing = the interval
  std::optional<core::TimeNs> execution_ns;  ///< measured; nothing = estimated
  core::TimeNs watchdog_ns = 0;              ///< 0 = none
  runtime::OverrunPolicy overrun = runtime::OverrunPolicy::kSkip;
  std::optional<runtime::FaultPolicy> on_fault;  ///< nothing = as the command line says
};

/// [project]
struct ProjectConfig {
  core::SourceRef at;
  std::vector<Placed> libraries;  ///< files of declarations, relative to plc.toml
};

/// [driver_kinds]
struct DriverKindsConfig {
  core::SourceRef at;
  std::vector<Placed> libraries;  ///< shared objects, relative to plc.toml
};

/// [taskblocks]
struct TaskblocksConfig {
  core::SourceRef at;
  std::vector<Placed> libraries;  ///< shared objects, relative to plc.toml
};

/// [retain]
struct RetainConfig {
  core::SourceRef at;
  Placed state;                            ///< folder, relative to plc.toml; or empty
  core::TimeNs interval_ns = 100'000'000;  ///< between two times of storing
};

enum class LogFormat : std::uint8_t { kAuto, kText, kJson, kJournal };

/// [log]
struct LogConfig {
  core::SourceRef at;
  LogFormat format = LogFormat::kAuto;
  Placed file;                                   ///< relative to plc.toml, or empty
  core::Severity level = core::Severity::kNote;  ///< the least that is written
  core::TimeNs repeat_ns = 60'000'000'000;       ///< 0 = all repetitions are written
  std::uint32_t most = 200;                      ///< of one source within repeat_ns
  std::uint32_t size_mb = 10;
  std::uint32_t keep = 5;
};

enum class RecordMode : std::uint8_t { kOn, kOff, kCheck };

/// [record]
struct RecordConfig {
  core::SourceRef at;
  RecordMode mode = RecordMode::kOn;
  Placed folder;  ///< of files; empty = memory only
  std::uint32_t folder_mb = 1024;
  std::uint32_t memory_mb = 32;
  std::uint32_t ring_mb = 4;  ///< of each task
  std::uint32_t faults = 10;  ///< files that are kept
};

/// [clock]
struct ClockConfig {
  core::SourceRef at;
  Placed zone;  ///< empty = the machine's
};

enum class EngineeringTls : std::uint8_t { kByAddress, kEverywhere };

/// [engineering]; the defaults are what plc-run does without a configuration.
struct EngineeringConfig {
  core::SourceRef at;
  bool enabled = true;
  core::SourceRef listen_at;          ///< of `listen`; no line when it is not there
  std::string address = "127.0.0.1";  ///< to listen on; IPv4 or IPv6 literal
  std::uint16_t port = 8061;          ///< 0 = any free one
  EngineeringTls tls = EngineeringTls::kByAddress;
  Placed certificate, key;      ///< files, relative to plc.toml; or empty
  std::vector<Placed> hosts;    ///< names of this machine
  std::vector<Placed> keys;     ///< files or folders of public keys, whose images may be uploaded; empty: all may
  Placed no_force, no_program;  ///< BOOL globals that forbid it while they are TRUE; or empty
  std::uint32_t max_clients = 128;
};

/// [guardian]
struct GuardianConfig {
  core::SourceRef at;
  bool enabled = true;                           ///< only ever started when a driver has outputs
  core::TimeNs hang_timeout_ns = 1'000'000'000;  ///< without a completed cycle of a task that serves outputs; 0 =
                                                 ///< deaths only. Slower tasks get three periods
};

struct Configuration {
  std::string file;  ///< as given; relative files in it are relative to its folder
  ProjectConfig project;
  DriverKindsConfig driver_kinds;
  std::vector<DriverConfig> drivers;
  std::vector<ChannelConfig> inputs;
  std::vector<ChannelConfig> outputs;
  SchedulerConfig scheduler;
  std::vector<TaskConfig> tasks;  ///< in the order of the file
  TaskblocksConfig taskblocks;
  RetainConfig retain;
  LogConfig log;
  RecordConfig record;
  ClockConfig clock;
  ModbusConfig modbus;
  EngineeringConfig engineering;
  GuardianConfig guardian;
  core::SourceRef at;          ///< the file itself, without a line
  core::SourceRef outputs_at;  ///< [outputs], or the file

  [[nodiscard]] const DriverConfig* driver(std::string_view name) const;
  /// A file that is named in plc.toml, seen from where that lies; empty stays empty.
  [[nodiscard]] std::string beside(const std::string& name) const;
};

/// "127.0.0.1:502", "[::1]:502", or "off", which has an empty address; nothing for anything else.
struct ListenText {
  std::string address;
  std::uint16_t port = 0;
};
std::optional<ListenText> parse_listen(std::string_view text);
/// As parse_listen() takes it; of an address that is not empty.
std::string listen_text(const ListenText& listen);

/// Makes the libraries of [driver_kinds] known: the kinds there are then, from whose rows the rest of the file is read.
/// What is wrong with one goes to `findings`.
using LoadKinds = std::function<DriverTypes(const Configuration& configuration, Findings& findings)>;

/// Reads TOML text. Reports every problem it finds (P73xx: syntax, unknown keys, wrong types, values out of range,
/// unknown drivers, double use of a variable or channel), each with line and column; nothing when there was an error.
/// Syntax errors stop at the first, as toml++ does. `types`: the kinds that drivers can be of; the configuration keeps
/// pointers to their rows.
std::optional<Configuration> read_configuration(std::string_view text, std::string_view file, DriverTypes types,
                                                core::Diagnostics& diagnostics, const LoadKinds& load_kinds = {});
/// Reads the file, at most 4 MB, and then its text. P7001 when it cannot be opened.
std::optional<Configuration> load_configuration(const std::string& path, DriverTypes types,
                                                core::Diagnostics& diagnostics, const LoadKinds& load_kinds = {});

}  // namespace plc::io
