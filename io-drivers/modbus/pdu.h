// PduHandler: Modbus requests and responses without a network: bytes in, bytes out.
//
// In: the PDU of a request (function code and data, 1..253 bytes, any content). Out: the PDU of its answer, never none:
// functions 1-6, 15, 16, 22, 23 and 43/14, exception 1 for all others. Checked in this order: function, length,
// quantity and form (3), address (2), permission (2), value (3). Does not belong here: frames, unit ids, connections.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "io-drivers/modbus/process_data.h"

namespace plc::modbus {

inline constexpr std::size_t kMaxPdu = 253;

/// What function 43/14 tells: VendorName, ProductCode, MajorMinorRevision (basic); VendorUrl, ProductName, ModelName,
/// UserApplicationName (regular). Texts that do not fit into an answer are cut.
using Identification = std::array<std::string, 7>;

class PduHandler {
 public:
  /// `data` must outlive it. With `read_only` the functions that write are unknown.
  PduHandler(ProcessData& data, Identification identification, bool read_only);

  /// Writes the answer to `request` into `response` and returns its size. Allocates nothing.
  std::size_t handle(std::span<const std::uint8_t> request, std::span<std::uint8_t, kMaxPdu> response);

 private:
  using Request = std::span<const std::uint8_t>;
  using Response = std::span<std::uint8_t, kMaxPdu>;
  /// Each fills `response` from byte 1 on and sets `size`, unless it returns an exception.
  Exception dispatch(Request request, Response response, std::size_t& size);
  Exception read_bits(Request request, Response response, std::size_t& size);
  Exception read_registers(Request request, Response response, std::size_t& size);
  Exception write_single_coil(Request request);
  Exception write_single_register(Request request);
  Exception write_multiple_coils(Request request);
  Exception write_multiple_registers(Request request);
  Exception mask_write_register(Request request);
  Exception read_write_registers(Request request, Response response, std::size_t& size);
  Exception identify(Request request, Response response, std::size_t& size) const;
  Exception change_registers(std::uint32_t first, Request values);

  ProcessData& data_;
  Identification identification_;
  bool read_only_;
};

}  // namespace plc::modbus
