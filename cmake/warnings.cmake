# Flags that every target of ours is compiled with. Warnings are errors: a warning is a question that nobody answered.
add_library(revisit_flags INTERFACE)
target_compile_options(revisit_flags INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
    -Wnon-virtual-dtor -Wold-style-cast -Werror
    # What g++ 12 gets wrong once it optimises: it sees overlaps in "text" + std::string (its bug 105651), and values that
    # may be uninitialised in an empty std::optional. clang-tidy's analyser looks for the latter.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict -Wno-maybe-uninitialized>
    # The processor must round as the shaders do: the CPU warp is the oracle the GPU is compared with.
    -ffp-contract=off)
if(REVISIT_SANITIZE)
    target_compile_options(revisit_flags INTERFACE -fsanitize=${REVISIT_SANITIZE} -fno-sanitize-recover=all
        -fno-omit-frame-pointer)
    target_link_options(revisit_flags INTERFACE -fsanitize=${REVISIT_SANITIZE})
endif()
