// Handlers for configurations that both spellings (TC6 and IEC 61131-10) share.
//
// In: tags of configurations, resources, tasks and instances. Out: Project::configurations. Does not belong here: the
// meaning of intervals and priorities.
#pragma once

#include "plcopen/reader_state.h"

namespace plc::plcopen {

void start_configuration(Reader& r, const Tag& tag);
void end_configuration(Reader& r);
void start_resource(Reader& r, const Tag& tag);
void end_resource(Reader& r);
void start_task(Reader& r, const Tag& tag);
void end_task(Reader& r);
/// A program instance of the open task, or beside the tasks of the open resource.
void add_instance(Reader& r, const Tag& tag, Attr type);

}  // namespace plc::plcopen
