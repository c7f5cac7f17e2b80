# SPDX-License-Identifier: MIT
# OpenCV's modules, as targets opencv_core, opencv_imgproc, ... Where OpenCV's own files for CMake
# are missing, the modules are looked for one by one: Debian ships those files with all of OpenCV
# only, which is 300 MB more than handyar needs.
find_package(OpenCV ${OpenCV_FIND_VERSION} QUIET CONFIG COMPONENTS core)
if(OpenCV_FOUND)
  foreach(component ${OpenCV_FIND_COMPONENTS})
    if(TARGET opencv_${component})
      set(OpenCV_${component}_FOUND TRUE)
    endif()
  endforeach()
else()
  find_path(OpenCV_INCLUDE_DIR opencv2/core/version.hpp PATH_SUFFIXES opencv4)
  mark_as_advanced(OpenCV_INCLUDE_DIR)
  if(OpenCV_INCLUDE_DIR)
    foreach(part MAJOR MINOR REVISION)
      file(STRINGS ${OpenCV_INCLUDE_DIR}/opencv2/core/version.hpp line REGEX "define CV_VERSION_${part} ")
      string(REGEX MATCH "[0-9]+" OpenCV_VERSION_${part} "${line}")
    endforeach()
    set(OpenCV_VERSION ${OpenCV_VERSION_MAJOR}.${OpenCV_VERSION_MINOR}.${OpenCV_VERSION_REVISION})
  endif()
  foreach(component ${OpenCV_FIND_COMPONENTS})
    find_library(OpenCV_${component}_LIBRARY opencv_${component})
    mark_as_advanced(OpenCV_${component}_LIBRARY)
    if(OpenCV_${component}_LIBRARY AND EXISTS ${OpenCV_INCLUDE_DIR}/opencv2/${component}.hpp)
      set(OpenCV_${component}_FOUND TRUE)
      if(NOT TARGET opencv_${component})
        add_library(opencv_${component} UNKNOWN IMPORTED)
        set_target_properties(opencv_${component} PROPERTIES
          IMPORTED_LOCATION ${OpenCV_${component}_LIBRARY}
          INTERFACE_INCLUDE_DIRECTORIES ${OpenCV_INCLUDE_DIR})
      endif()
    endif()
  endforeach()
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCV
  REQUIRED_VARS OpenCV_VERSION
  VERSION_VAR OpenCV_VERSION
  HANDLE_COMPONENTS)
