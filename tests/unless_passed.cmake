# Runs a test program, unless it passed before and is the same to the byte: cmake -D PROGRAM=... -D STAMP=... -P. For the
# sanitizers, under which programs read nothing but themselves and do the same each time. Whoever wants them run again
# removes the stamps.
file(SHA256 ${PROGRAM} bytes)
set(tried "${bytes} $ENV{GTEST_FILTER} $ENV{ASAN_OPTIONS} $ENV{UBSAN_OPTIONS} $ENV{TSAN_OPTIONS}")
if(EXISTS ${STAMP})
    file(READ ${STAMP} passed)
    if(passed STREQUAL tried)
        message("passed before, and is the same program")
        return()
    endif()
endif()
file(REMOVE ${STAMP})
execute_process(COMMAND ${PROGRAM} RESULT_VARIABLE status)
if(NOT status EQUAL 0)
    message(FATAL_ERROR "${PROGRAM} failed: ${status}")
endif()
file(WRITE ${STAMP} "${tried}")
