# The strict reader shows nodes of yaml-cpp.
find_package(yaml-cpp REQUIRED)
target_link_libraries(core_base_test yaml-cpp)
target_link_libraries(core_base_test quadmath)  # functions of 113 bits
