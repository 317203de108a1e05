# Flags that every target of ours is compiled with. Warnings are errors: a warning is a question that nobody answered.
add_library(revisit_flags INTERFACE)
target_compile_options(revisit_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    -Wnon-virtual-dtor -Wold-style-cast -Werror
    # What g++ 12 gets wrong once it optimises: it sees overlaps in "text" + std::string (its bug 105651), and values that
    # may be uninitialised in an empty std::optional. clang-tidy's analyser looks for the latter.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict -Wno-maybe-uninitialized>
    # The processor must round as the shaders do: the CPU warp is the oracle the GPU is compared with.
    -ffp-contract=off)
# SSE4.2, which every PC has had since 2013: rounding, choosing and counting bits by one instruction each. `revisit build`
# takes a twelfth less time. More than that (AVX2) would part Eigen's types from those in Ceres' library; hot loops have
# all there is at run time, through Highway.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^(x86_64|AMD64)$")
    target_compile_options(revisit_flags INTERFACE -march=x86-64-v2)
endif()
if(REVISIT_SANITIZE)
    target_compile_options(revisit_flags INTERFACE -fsanitize=${REVISIT_SANITIZE} -fno-sanitize-recover=all
        -fno-omit-frame-pointer)
    target_link_options(revisit_flags INTERFACE -fsanitize=${REVISIT_SANITIZE})
endif()
