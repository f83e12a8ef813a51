# Creates a virtual environment in the build folder with the packages for building and testing. It is created again
# whenever the list of packages changes.
set(requirements ${CMAKE_CURRENT_SOURCE_DIR}/requirements.txt)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${requirements})
execute_process(COMMAND ${PROJECT_SOURCE_DIR}/tests/venv ${PROJECT_BINARY_DIR}/python-environment ${requirements}
  OUTPUT_VARIABLE Python_EXECUTABLE OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE failed)
if(failed)
  message(FATAL_ERROR "The Python packages of python/requirements.txt could not be installed from PyPI into "
    "${PROJECT_BINARY_DIR}/python-environment; -DLATELIGHT_PYTHON=OFF builds without the Python package")
endif()
