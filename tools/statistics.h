// Printing of what a run measured: tables per task, memory, events and faults with their drawn elements.
//
// In: a resource and statistics. Out: text. Does not belong here: measuring.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "runtime/resource.h"
#include "runtime/sched/task.h"

namespace plc::tools {

/// "plant.xml:12:3 [POU Mixer, block 14]": the drawn element that a code word is of.
std::string place_text(const bytecode::Image& image, std::uint32_t pou, std::uint32_t word);

/// One line per instruction that raised events.
void print_events(const runtime::Resource& resource, std::ostream& out);
/// One fault as a diagnostic line.
std::string fault_text(const runtime::Resource& resource, const runtime::TaskFault& fault);
/// The same as a line.
void print_fault(const runtime::Resource& resource, const runtime::TaskFault& fault, std::ostream& out);
/// A line for each taskblock that allocated memory in its cycle.
void print_allocations(const runtime::Resource& resource, std::ostream& out);
/// "memory: 12.3 MB resident, 40.1 MB at most": VmRSS and VmHWM of this process.
void print_memory(std::ostream& out);
/// Number of variables, code size and how boolean runs were linked, per task.
void print_link_report(const runtime::Resource& resource, std::ostream& out);

/// Aligned columns: the first row is the heading. Columns of numbers are right aligned, but for the first one; those of
/// texts, left aligned.
void print_table(const std::vector<std::vector<std::string>>& rows, std::ostream& out);

}  // namespace plc::tools
