# A host of the plug-in that renders stages. Stages include headers of TBB, which must be those that OpenUSD was built with;
# and the library of a module bpy needs the symbols of a Python, which OpenUSD in other programs may do without.
get_filename_component(usd_folder ${ALABASTER_USD_LIBRARY} DIRECTORY)
find_path(ALABASTER_USD_TBB_HEADERS tbb/task.h HINTS ${usd_folder}/../../../../../include NO_DEFAULT_PATH
  DOC "Folder that holds tbb/task.h of the TBB of the host's OpenUSD")
find_package(Python3 QUIET COMPONENTS Interpreter Development.Embed)
if(NOT ALABASTER_USD_TBB_HEADERS)
  message(STATUS "Host for stages: skipped, because ALABASTER_USD_TBB_HEADERS is not set")
  return()
endif()
add_executable(record_stage ${CMAKE_CURRENT_LIST_DIR}/record_stage.cpp)
target_include_directories(record_stage SYSTEM BEFORE PRIVATE ${ALABASTER_USD_TBB_HEADERS})
target_link_libraries(record_stage PRIVATE alabaster_warnings alabaster_usd nlohmann_json::nlohmann_json
  $<$<TARGET_EXISTS:Python3::Python>:-Wl,--no-as-needed Python3::Python>)
file(GLOB tbb ${usd_folder}/libtbb.so.*)
target_link_libraries(record_stage PRIVATE ${tbb})
set_target_properties(record_stage PROPERTIES BUILD_RPATH ${usd_folder})
