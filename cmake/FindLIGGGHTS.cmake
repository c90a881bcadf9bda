# LIGGGHTS as Debian ships it (liggghts, libliggghts-dev): the target LIGGGHTS::LIGGGHTS.
find_path(LIGGGHTS_INCLUDE_DIR lammps.h PATH_SUFFIXES liggghts)
find_library(LIGGGHTS_LIBRARY liggghts)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(LIGGGHTS
  REQUIRED_VARS LIGGGHTS_LIBRARY LIGGGHTS_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "install libliggghts-dev, or configure with -DGRANARY_WITH_LIGGGHTS=OFF")

# LIGGGHTS generates these lists of its contact models when it is built, includes them everywhere and does not install them.
# They only declare constants for the models, which no code of ours names: empty ones do.
set(generated ${CMAKE_BINARY_DIR}/generated/liggghts)
foreach(model surface normal tangential cohesion rolling)
  if(LIGGGHTS_INCLUDE_DIR AND NOT EXISTS ${LIGGGHTS_INCLUDE_DIR}/style_${model}_model.h)
    file(CONFIGURE OUTPUT ${generated}/style_${model}_model.h CONTENT "// none named here\n")
  endif()
endforeach()

if(LIGGGHTS_FOUND AND NOT TARGET LIGGGHTS::LIGGGHTS)
  add_library(LIGGGHTS::LIGGGHTS UNKNOWN IMPORTED)
  set_target_properties(LIGGGHTS::LIGGGHTS PROPERTIES
    IMPORTED_LOCATION ${LIGGGHTS_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES "${LIGGGHTS_INCLUDE_DIR};${generated}"
    INTERFACE_LINK_LIBRARIES MPI::MPI_CXX)
endif()
mark_as_advanced(LIGGGHTS_INCLUDE_DIR LIGGGHTS_LIBRARY)
