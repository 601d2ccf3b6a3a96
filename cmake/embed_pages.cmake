# cmake -DPAGES=<folder> -DOUTPUT=<file.cpp> -P embed_pages.cmake: docs/problems/*.md as C++ raw strings.
file(GLOB pages ${PAGES}/*.md)
list(SORT pages)
set(rows "")
foreach(page ${pages})
  get_filename_component(code ${page} NAME_WE)
  file(READ ${page} text)
  string(APPEND rows "    {\"${code}\", R\"PAGE(${text})PAGE\"},\n")
endforeach()
set(source "#include \"tools/problem_pages.h\"

namespace plc::tools {
namespace {
constexpr ProblemPage kPages[] = {
    {\"\", \"\"},
${rows}};
}  // namespace
std::span<const ProblemPage> problem_pages() { return std::span(kPages).subspan(1); }
}  // namespace plc::tools
")
file(WRITE ${OUTPUT} "${source}")
