// Image: a compiled project as data. It may be wrong; only verify() makes a VerifiedImage, and the runtime takes
// nothing else.
//
// In: made by codegen or load(). Out: save(), verify(), the disassembler. Every table has a typed map (types + a root
// structure), and every operand names a typed leaf of it. Initial bytes are complete: string capacities are in place.
// Does not belong here: IR, XML, threads.
//
// Memory of one running task (laid out by the runtime): [copy of the global table][constants][task instance][frames].
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bytecode/opcode.h"
#include "bytecode/probes.h"
#include "core/diagnostics.h"
#include "core/options.h"
#include "core/result.h"
#include "core/source_ref.h"
#include "core/types.h"

namespace plc::bytecode {

inline constexpr std::uint32_t kFormatVersion = 7;
/// Nesting of CALL_POU / CALL_FN that an image may need.
inline constexpr std::uint32_t kMaxCallDepth = 64;
/// Loop iterations (LOOP_JUMP) one execution of a task may take unless plc.toml says otherwise.
inline constexpr std::uint32_t kDefaultLoopBudget = 1'000'000;

enum class TypeKind : std::uint8_t { kScalar, kString, kArray, kStruct, kRef };

/// What a structure field is for; the debugger, stimulus and traces read it.
enum class FieldRole : std::uint8_t { kMember, kInput, kOutput, kInOut, kLocal, kTemp, kReturnValue, kHidden, kState };

struct ImageField {
  std::string name;  ///< as declared; hidden ones contain '#'
  std::uint32_t type = 0;
  std::uint32_t offset = 0;  ///< bytes from the start of the structure, aligned for the type
  FieldRole role = FieldRole::kMember;
  bool constant = false;
  bool retain = false;      ///< kept over a warm start, with all that is in it
  bool persistent = false;  ///< kept over a cold start too
  bool fresh = false;       ///< NON_RETAIN: begins anew, also in an instance that is kept
  /// Has a meaning for this code alone (edges, active steps): kept only as long as the program is the same.
  bool internal = false;
};

/// A variable of a POU that lives in the global table (VAR_EXTERNAL, or located by AT), under its name in the POU. For
/// access by path only: code names the global table itself.
struct ImageAlias {
  std::string name;
  std::uint32_t global = 0;  ///< field of Image::global_type
};

struct ImageType {
  TypeKind kind = TypeKind::kScalar;
  core::TypeId elementary = core::TypeId::kBool;  ///< kScalar, kString: for display and normalisation
  std::string name;                               ///< declared name, or empty
  std::uint32_t size = 0;                         ///< bytes
  std::uint32_t align = 1;
  std::uint16_t capacity = 0;  ///< kString, characters
  std::uint32_t element =
      0;                    ///< kArray element, kRef target (a kRef target may have any index; all others a lower one)
  std::uint32_t count = 0;  ///< kArray elements
  std::int64_t lower = 0;   ///< kArray: declared lower bound; kScalar with limits: smallest value
  std::int64_t upper = 0;   ///< kScalar with limits: largest value
  bool limited = false;     ///< kScalar: subrange or enumeration, outside values are refused
  std::vector<std::string> members;  ///< kScalar enumerations: names in the order of member_values
  std::vector<std::int64_t> member_values;
  std::vector<ImageField> fields;   ///< kStruct, ascending offsets
  std::vector<ImageAlias> aliases;  ///< kStruct of instances, in declaration order
};

struct DebugEntry {
  std::uint32_t word = 0;  ///< this source covers code words from here to the next entry
  core::SourceRef at;
};

/// An input of a taskblock that is wired: the object reads the variable at the other end of the wire, and nothing is
/// copied. Offsets are in the instance of the POU.
struct ImageWire {
  std::uint32_t block = 0;   ///< where the taskblock instance is
  std::uint32_t input = 0;   ///< field of its type
  std::uint32_t source = 0;  ///< where a value of exactly the field's type is, outside of the taskblock instance
};

/// A queue that a port of a taskblock is connected to.
struct ImageQueuePort {
  std::uint32_t block = 0;  ///< where the taskblock instance is, in the instance of the POU
  std::string port;         ///< of the taskblock
  std::uint32_t queue = 0;  ///< index into Image::queues
  bool takes = false;       ///< elements out of the queue; else it puts them in
};

enum class PouKind : std::uint8_t { kProgram, kFunctionBlock, kFunction, kTask };

struct ImagePou {
  std::string name;
  PouKind kind = PouKind::kProgram;
  std::uint32_t instance_type = 0;  ///< a kStruct; functions: an empty one
  std::uint32_t frame_type = 0;     ///< a kStruct: parameters and locals of functions, VAR_TEMP, intermediate values
  std::vector<std::byte> instance_initial;  ///< instance_type's size: a fresh instance
  std::vector<std::byte>
      frame_initial;  ///< frame_type's size: the frame at each call of a function, at start otherwise
  std::vector<std::uint32_t> code;
  std::vector<DebugEntry> debug;            ///< ascending words
  std::vector<ImageWire> wires;             ///< no two of one input
  std::vector<ImageQueuePort> queue_ports;  ///< no two of one port
};

/// First field of the instances of a taskblock: the number of the C++ object that belongs to it, while the image runs.
inline constexpr const char* kObjectField = "#object";

/// A standard block, or a taskblock when the standard library has none of this name.
struct ImageBlock {
  std::string name;
  std::uint64_t layout_hash = 0;  ///< of the library; another layout is refused
  std::uint32_t type = 0;         ///< the kStruct of its ports
};

/// A global variable: field of the global table plus what configuration and drivers need.
struct ImageGlobal {
  std::string list;           ///< "GVL", or empty
  std::string address;        ///< "%IX0.0" as written, or empty
  std::uint32_t writers = 0;  ///< number of tasks that write it; 0 = inputs and constants, owned by the system
};

/// A queue between tasks: a ring for each task that puts, which one task takes from.
struct ImageQueue {
  std::string name;
  std::uint32_t type = 0;           ///< of an element
  std::uint32_t capacity = 0;       ///< elements, of each ring
  std::vector<std::uint32_t> puts;  ///< tasks that put elements in or ask for space, ascending
  std::uint32_t takes = kNoTask;    ///< the task that takes them out, or kNoTask

  static constexpr std::uint32_t kNoTask = 0xffffffffu;
};

struct ImageTask {
  std::string name;
  std::int64_t period_ns = 0;  ///< 0 = freewheeling
  std::int32_t priority = 0;   ///< 0 is the highest
  std::string single;          ///< path of the BOOL global whose rising edge releases the task, or empty
  std::uint32_t body =
      0;  ///< POU of kind kTask: READ_N.., CALL_POU per program, WRITE_N..; its instance holds the program instances
};

struct Image {
  core::CompileOptions options;
  std::string project;
  std::string product;  ///< "PICARD 0.1.0"
  /// Addresses of Modbus that were frozen when it was compiled, the text of a lock file; empty = none. Who serves them
  /// checks it.
  std::string frozen_addresses;
  /// What the POUs look like, packed (drawings.h); empty = it is not known. It says nothing about what the image does:
  /// fingerprint() leaves it out.
  std::vector<std::byte> drawings;
  std::vector<std::string> files;  ///< SourceRef::file indexes it
  std::vector<ImageType> types;
  std::uint32_t global_type = 0;     ///< kStruct: the global table
  std::vector<ImageGlobal> globals;  ///< parallel to the fields of global_type
  std::vector<std::byte> global_initial;
  std::uint32_t const_type = 0;  ///< kStruct: the constants
  std::vector<std::byte> const_bytes;
  std::vector<ImagePou> pous;
  std::vector<ImageBlock> blocks;
  std::vector<std::string> functions;  ///< stdlib keys, "ADD:DINT"
  std::vector<ImageQueue> queues;
  std::vector<ImageTask> tasks;
  /// Where the code has what drawings and texts show, by POU; empty = it was compiled without. Nothing that executes
  /// for control reads it.
  std::vector<PouProbes> probes;
};

/// Serialises: header (magic, format version, XXH3 checksum of the rest), then the sections.
std::vector<std::byte> save(const Image& image);
/// Decodes bytes. Refuses wrong magic, version, checksum, truncation and sizes that the bytes cannot hold (P60xx).
core::Result<Image> load(std::span<const std::byte> bytes);
/// Recomputes the checksum in place (for tools that edit images, such as the fuzzer).
void reseal(std::span<std::byte> bytes);

/// Proof that an image is safe to run: no operand, jump, call or initial value can leave its typed place.
class VerifiedImage {
 public:
  [[nodiscard]] const Image& image() const { return image_; }
  /// Deepest nesting of calls from any task, at most kMaxCallDepth.
  [[nodiscard]] std::uint32_t call_depth() const { return call_depth_; }

 private:
  friend std::optional<VerifiedImage> verify(Image image, core::Diagnostics& diagnostics);
  VerifiedImage(Image image, std::uint32_t call_depth) : image_(std::move(image)), call_depth_(call_depth) {}
  Image image_;
  std::uint32_t call_depth_;
};

/// Checks every rule of bytecode/rules.def. Reports each broken rule (P6xxx naming the V-rule) and returns nothing.
std::optional<VerifiedImage> verify(Image image, core::Diagnostics& diagnostics);

/// The leaf (scalar, string or reference) of `type` at byte `offset`, or nothing when the offset is not the start of
/// one.
std::optional<std::uint32_t> leaf_at(const Image& image, std::uint32_t type, std::uint32_t offset);
/// True when a value of exactly type `wanted` starts at byte `offset` of `type`.
bool place_at(const Image& image, std::uint32_t type, std::uint32_t offset, std::uint32_t wanted);
/// True when instances of a taskblock may have this type: its first field is kObjectField, a hidden UDINT.
bool is_taskblock_type(const Image& image, std::uint32_t type);
/// Machine representation of a leaf type.
core::Rep rep_of(const ImageType& type);

/// Listing of the whole image; assemble() reads it back (tests, tools).
std::string disassemble(const Image& image);
core::Result<Image> assemble(std::string_view text);

}  // namespace plc::bytecode
