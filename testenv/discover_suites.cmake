# Read by ctest when it starts (TEST_INCLUDE_FILES): each suite of a GoogleTest program becomes a test named
# PROGRAM.SUITE. A suite, not a test, has a process, because tests of a suite share what is costly to make.

# add_suites(<program> <timeout in seconds> <label> [<suite> ...]): the suites named have the label long instead.
# ctest sets no policies.
function(add_suites program timeout label)
  get_filename_component(name ${program} NAME)
  if(NOT EXISTS ${program})
    add_test(${name}_NOT_BUILT ${program})
    set_tests_properties(${name}_NOT_BUILT PROPERTIES LABELS ${label})
    return()
  endif()
  execute_process(COMMAND ${program} --gtest_list_tests OUTPUT_VARIABLE listed RESULT_VARIABLE failed)
  if(failed)
    add_test(${name}_NOT_LISTED ${program} --gtest_list_tests)
    set_tests_properties(${name}_NOT_LISTED PROPERTIES LABELS ${label})
    return()
  endif()
  string(REGEX MATCHALL "(^|\n)[^ \n]+\\.( |\n)" suites "${listed}")
  foreach(suite IN LISTS suites)
    string(REGEX REPLACE "[ \n]|\\.[ \n]" "" suite "${suite}")
    set(of_suite ${label})
    set(cost 0)
    list(FIND ARGN ${suite} found)
    if(found GREATER -1)
      set(of_suite long)
      set(cost 100)  # starts before the others
    endif()
    add_test(${name}.${suite} ${program} "--gtest_filter=${suite}.*")
    set_tests_properties(${name}.${suite} PROPERTIES TIMEOUT ${timeout} LABELS ${of_suite} COST ${cost})
  endforeach()
endfunction()
