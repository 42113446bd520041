# Writes the files of the viewer's page into a source:
#   cmake -D FOLDER=tools/view/page -D "FILES=index.html style.css" -D SOURCE=page_files.cpp -P page_files.cmake
separate_arguments(files UNIX_COMMAND "${FILES}")
set(types_html "text/html; charset=utf-8")
set(types_css "text/css; charset=utf-8")
set(types_js "text/javascript; charset=utf-8")
set(rows "")
foreach(file IN LISTS files)
  file(READ ${FOLDER}/${file} text)
  string(REGEX REPLACE ".*\\." "" ending ${file})
  string(APPEND rows "    {\"${file}\", \"${types_${ending}}\", R\"page(${text})page\"},\n")
endforeach()
file(WRITE ${SOURCE} "#include \"view/page_files.h\"\n
namespace pvol::viewer {\n
std::span<const PageFile> page_files() {
  static constexpr PageFile kFiles[] = {
${rows}  };
  return kFiles;
}\n
}  // namespace pvol::viewer\n")
