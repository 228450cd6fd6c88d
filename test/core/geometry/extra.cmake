# The oracle by dual transform runs on Qhull, that of GJK on libccd; the fuzz target's assertions are shared.
find_package(ccd REQUIRED)
find_library(QHULL_R_LIBRARY NAMES qhull_r REQUIRED)
find_path(QHULL_R_INCLUDE_DIR libqhull_r/libqhull_r.h REQUIRED)
target_include_directories(core_geometry_test PRIVATE ${QHULL_R_INCLUDE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/geometry
  ${CMAKE_CURRENT_SOURCE_DIR}/../fuzz)
target_link_libraries(core_geometry_test ccd ${QHULL_R_LIBRARY})
target_link_libraries(core_geometry_test quadmath)  # square roots and angles of 113 bits
