# cpack in a build folder makes klangprobe_*.deb and libklangprobe-dev_*.deb for Debian 12.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME klangprobe)
set(CPACK_PACKAGE_VENDOR "Klangprobe")
set(CPACK_PACKAGE_CONTACT "The Klangprobe maintainers <maintainers@klangprobe.example>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Material parameters from the sound of struck objects")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL ${KLANG_PACKAGES})
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_KLANGPROBE_PACKAGE_NAME klangprobe)
set(CPACK_DEBIAN_KLANGPROBE_PACKAGE_SECTION sound)
set(CPACK_DEBIAN_KLANGPROBE_PACKAGE_SHLIBDEPS ON)
# Pictures need a display, of which Xvfb makes one; modes on other devices need an OpenCL driver.
set(CPACK_DEBIAN_KLANGPROBE_PACKAGE_SUGGESTS klangprobe-mpi)
set(CPACK_DEBIAN_KLANGPROBE_PACKAGE_RECOMMENDS "xvfb, libgl1-mesa-dri, pocl-opencl-icd, fonts-dejavu-core")
set(CPACK_COMPONENT_KLANGPROBE_DESCRIPTION
  "Klangprobe finds elastic constants and damping of a struck body from its recording and its dimensions, with
 error bars, says what the recording does not determine, and plays what it fitted.")

set(CPACK_DEBIAN_LIBKLANGPROBE-DEV_PACKAGE_NAME libklangprobe-dev)
set(CPACK_DEBIAN_LIBKLANGPROBE-DEV_PACKAGE_SECTION libdevel)
# What cmake/KlangDependencies.cmake looks for.
set(CPACK_DEBIAN_LIBKLANGPROBE-DEV_PACKAGE_DEPENDS
  "libboost-dev, libbullet-dev, libceres-dev, libcli11-dev, libeigen3-dev, libfftw3-dev, libhdf5-dev, libmatio-dev, libmumps-seq-dev, libnanoflann-dev, libopenblas-dev, libpng-dev, libpugixml-dev, librsvg2-dev, libsamplerate0-dev, libsndfile1-dev, libspectra-dev, libssl-dev, libsuitesparse-dev, libtbb-dev, libtet1.5-dev, libtomlplusplus-dev, libvtk9-dev, nlohmann-json3-dev, ocl-icd-opencl-dev, pkg-config, zlib1g-dev")
if(PORTAUDIO_FOUND)
  string(APPEND CPACK_DEBIAN_LIBKLANGPROBE-DEV_PACKAGE_DEPENDS ", portaudio19-dev")
endif()
if(TARGET klang_openvdb)
  string(APPEND CPACK_DEBIAN_LIBKLANGPROBE-DEV_PACKAGE_DEPENDS ", libopenvdb-dev, libboost-dev")
endif()
set(CPACK_COMPONENT_LIBKLANGPROBE-DEV_DESCRIPTION "Libraries and headers of Klangprobe, with a CMake package: find_package(klangprobe).")

set(CPACK_DEBIAN_KLANGPROBE-MPI_PACKAGE_NAME klangprobe-mpi)
set(CPACK_DEBIAN_KLANGPROBE-MPI_PACKAGE_SECTION sound)
set(CPACK_DEBIAN_KLANGPROBE-MPI_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_KLANGPROBE-MPI_PACKAGE_DEPENDS "klangprobe (= ${PROJECT_VERSION}), openmpi-bin")
set(CPACK_COMPONENT_KLANGPROBE-MPI_DESCRIPTION "Spreads Klangprobe's work over processes and machines: mpirun -n 4 klang ...")

set(CPACK_DEBIAN_PYTHON3-KLANGPROBE_PACKAGE_NAME python3-klangprobe)
set(CPACK_DEBIAN_PYTHON3-KLANGPROBE_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON3-KLANGPROBE_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PYTHON3-KLANGPROBE_PACKAGE_DEPENDS "python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
set(CPACK_DEBIAN_PYTHON3-KLANGPROBE_PACKAGE_SUGGESTS "python3-pandas")
set(CPACK_COMPONENT_PYTHON3-KLANGPROBE_DESCRIPTION "Klangprobe as a Python package: import klangprobe.")
include(CPack)
