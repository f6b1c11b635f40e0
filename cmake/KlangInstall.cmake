include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
get_property(libraries GLOBAL PROPERTY KLANG_LIBRARIES)
get_property(folders GLOBAL PROPERTY KLANG_HEADER_FOLDERS)
