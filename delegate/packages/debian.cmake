# `cpack -G DEB` in the build folder: one .deb with all that is built and installed. The package is not named alabaster,
# because Debian's python3-alabaster, the theme of Sphinx, has that source name; the library, the Python module and the
# CMake package are named hdAlabaster as well.
set(CPACK_PACKAGE_NAME hdalabaster)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_VENDOR Alabaster)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "path tracer for translucent materials")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Alabaster renders skin, wax, marble, jade and leaves on the CPU. Light below
surfaces is a path-traced random walk. The package has the program, its window,
the library with C and C++ headers, the Python module hdalabaster, the Blender
add-on and the manual.")
set(ALABASTER_MAINTAINER "Alabaster maintainers <maintainers@alabaster.example>" CACHE STRING "Maintainer of the Debian package")
set(CPACK_DEBIAN_PACKAGE_MAINTAINER ${ALABASTER_MAINTAINER})
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE gzip)  # xz takes a minute for Open Image Denoise
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# Libraries of other packages by dpkg-shlibdeps; it finds those of this package in the staging folder.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
file(WRITE ${CMAKE_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
file(WRITE ${CMAKE_BINARY_DIR}/debian/shlibs "libhdAlabaster ${PROJECT_VERSION_MAJOR} hdalabaster (>= ${PROJECT_VERSION})
libalabaster_images ${PROJECT_VERSION_MAJOR} hdalabaster (>= ${PROJECT_VERSION})\n")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${CMAKE_BINARY_DIR}/debian/triggers ${CMAKE_BINARY_DIR}/debian/shlibs)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/lib ${CMAKE_BINARY_DIR}/oidn/pyoidn/oidn/lib)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "blender, bash-completion")
if(TARGET alabaster_python)
  get_directory_property(python DIRECTORY ${PROJECT_SOURCE_DIR}/delegate/python DEFINITION Python_VERSION_MINOR)
  math(EXPR next "${python} + 1")
  set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3 (>= 3.${python}), python3 (<< 3.${next})")
  set(CPACK_DEBIAN_PACKAGE_RECOMMENDS python3-numpy)
endif()
set(ALABASTER_SOURCE ${PROJECT_SOURCE_DIR})
configure_file(${CMAKE_CURRENT_LIST_DIR}/debian_files.cmake.in ${CMAKE_BINARY_DIR}/debian_files.cmake @ONLY)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_BINARY_DIR}/debian_files.cmake)
include(CPack)
