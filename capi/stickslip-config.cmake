# find_package(stickslip) gives stickslip::stickslip, the shared library, and stickslip::static.
get_filename_component(_stickslip_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
if(NOT TARGET stickslip::stickslip)
  add_library(stickslip::stickslip SHARED IMPORTED)
  set_target_properties(stickslip::stickslip PROPERTIES
    IMPORTED_LOCATION "${_stickslip_prefix}/lib/libstickslip.so.@VERSION@"
    IMPORTED_SONAME "libstickslip.so.@MAJOR@"
    INTERFACE_INCLUDE_DIRECTORIES "${_stickslip_prefix}/include")
  add_library(stickslip::static STATIC IMPORTED)
  set_target_properties(stickslip::static PROPERTIES
    IMPORTED_LOCATION "${_stickslip_prefix}/lib/libstickslip.a"
    INTERFACE_LINK_LIBRARIES "@SYSTEM_LIBRARIES@"
    INTERFACE_INCLUDE_DIRECTORIES "${_stickslip_prefix}/include")
endif()
unset(_stickslip_prefix)
