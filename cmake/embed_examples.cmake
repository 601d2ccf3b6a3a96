# cmake -DFOLDER=<taskblocks> -DOUTPUT=<file.cpp> -P embed_examples.cmake: <folder>/*/*.xml as C++ raw strings.
file(GLOB examples RELATIVE ${FOLDER} ${FOLDER}/*/*.xml)
list(SORT examples)
set(rows "")
foreach(example ${examples})
  file(READ ${FOLDER}/${example} text)
  string(APPEND rows "    {\"${example}\", R\"EXAMPLE(${text})EXAMPLE\"},\n")
endforeach()
file(WRITE ${OUTPUT} "#include \"tools/taskblock_examples.h\"

namespace plc::tools {
namespace {
constexpr TaskblockExample kExamples[] = {
    {\"\", \"\"},
${rows}};
}  // namespace
std::span<const TaskblockExample> taskblock_examples() { return std::span(kExamples).subspan(1); }
}  // namespace plc::tools
")
