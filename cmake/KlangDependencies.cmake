# Every dependency comes from Debian 12; docs/dependencies.md says why each one is here.
include_guard()
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(TBB 2021.8 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(SNDFILE REQUIRED IMPORTED_TARGET sndfile>=1.2)
pkg_check_modules(SAMPLERATE REQUIRED IMPORTED_TARGET samplerate>=0.2)
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3>=3.3)
pkg_check_modules(MATIO REQUIRED IMPORTED_TARGET matio>=1.5)
pkg_check_modules(CRYPTO REQUIRED IMPORTED_TARGET libcrypto>=3)
pkg_check_modules(HDF5 REQUIRED IMPORTED_TARGET hdf5-serial>=1.10)
pkg_check_modules(RSVG REQUIRED IMPORTED_TARGET librsvg-2.0>=2.54 cairo>=1.16)
pkg_check_modules(TOMLPLUSPLUS REQUIRED IMPORTED_TARGET tomlplusplus>=3.3)
pkg_check_modules(BULLET REQUIRED bullet-float64>=3.24)  # float64: the other build's collision tolerances are 1e-3 m
pkg_check_modules(PORTAUDIO IMPORTED_TARGET portaudio-2.0)  # only for klang listen --device
find_package(PNG 1.6 REQUIRED)
find_package(LibLZMA 5.2 REQUIRED)
find_package(ZLIB 1.2 REQUIRED)
find_package(pugixml 1.12 REQUIRED)
find_package(OpenCL REQUIRED)
find_package(Ceres 2.1 REQUIRED)
find_package(CLI11 2.1 REQUIRED)
find_package(Spectra 1.0 REQUIRED NO_MODULE)
find_package(VTK 9.1 REQUIRED COMPONENTS CommonCore CommonDataModel CommonExecutionModel FiltersCore IOCore IOGeometry IOXML)  # files only; pictures are KLANG_WITH_VTK's

function(klang_find_library target header library)
  string(TOUPPER ${target} prefix)
  find_path(${prefix}_INCLUDE_DIR ${header} PATH_SUFFIXES suitesparse mumps_seq REQUIRED)
  add_library(${target} INTERFACE IMPORTED GLOBAL)
  target_include_directories(${target} SYSTEM INTERFACE ${${prefix}_INCLUDE_DIR})
  foreach(name ${library} ${ARGN})
    find_library(KLANG_LIB_${name} ${name} REQUIRED)
    target_link_libraries(${target} INTERFACE ${KLANG_LIB_${name}})
  endforeach()
endfunction()
find_path(KLANG_NANOFLANN_INCLUDE_DIR nanoflann.hpp REQUIRED)
add_library(klang_nanoflann INTERFACE IMPORTED GLOBAL)
target_include_directories(klang_nanoflann SYSTEM INTERFACE ${KLANG_NANOFLANN_INCLUDE_DIR})
klang_find_library(klang_tetgen tetgen.h tet)
klang_find_library(klang_cholmod cholmod.h cholmod suitesparseconfig)
klang_find_library(klang_openblas cblas.h openblas)
klang_find_library(klang_mumps dmumps_c.h dmumps_seq mumps_common_seq)

# Liquids as .vdb; without it the program says so.
find_path(KLANG_OPENVDB_INCLUDE_DIR openvdb/openvdb.h)
find_library(KLANG_LIB_openvdb openvdb)
if(KLANG_OPENVDB_INCLUDE_DIR AND KLANG_LIB_openvdb)
  find_library(KLANG_LIB_Imath Imath-3_1 REQUIRED)  # half floats in OpenVDB's headers
  add_library(klang_openvdb INTERFACE IMPORTED GLOBAL)
  target_include_directories(klang_openvdb SYSTEM INTERFACE ${KLANG_OPENVDB_INCLUDE_DIR})
  target_link_libraries(klang_openvdb INTERFACE ${KLANG_LIB_openvdb} ${KLANG_LIB_Imath} TBB::tbb)
endif()

# Collision and what it is built on alone; system headers, whose warnings are not ours.
add_library(klang_bullet INTERFACE IMPORTED GLOBAL)
target_include_directories(klang_bullet SYSTEM INTERFACE ${BULLET_INCLUDE_DIRS})
target_compile_definitions(klang_bullet INTERFACE BT_USE_DOUBLE_PRECISION)
target_link_libraries(klang_bullet INTERFACE BulletCollision-float64 LinearMath-float64)

if(KLANG_WITH_VTK)
  find_package(VTK 9.1 REQUIRED COMPONENTS CommonCore CommonDataModel CommonExecutionModel FiltersCore FiltersGeneral
    FiltersGeometry IOXML RenderingCore RenderingOpenGL2)
  set(KLANG_VTK_RENDERING VTK::CommonCore VTK::CommonDataModel VTK::CommonExecutionModel VTK::FiltersCore
    VTK::FiltersGeneral VTK::FiltersGeometry VTK::IOXML VTK::RenderingCore VTK::RenderingOpenGL2)
endif()
