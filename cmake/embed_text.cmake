# cmake -DINPUT=<file> -DOUTPUT=<file.cpp> -DHEADER=<header> -DNAMESPACE=<a::b> -DFUNCTION=<name> -P embed_text.cmake:
# a text file as what the function, declared in the header, returns.
file(READ ${INPUT} text)
file(WRITE ${OUTPUT} "#include \"${HEADER}\"

namespace ${NAMESPACE} {
std::string_view ${FUNCTION}() {
  return R\"TEXT(${text})TEXT\";
}
}  // namespace ${NAMESPACE}
")
