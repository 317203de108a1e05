# revisit_shader(name.stage variable [folder]): compiles FOLDER/name.stage (default: shaders/) to a header
# spirv/name.stage.h in the current build folder that holds the SPIR-V words in VARIABLE, and appends it to
# REVISIT_SHADER_HEADERS. The compiler reports what it included, so that a changed shared header recompiles its shaders.
# Of optimised words (-Os) lavapipe makes pipelines in half the time.
function(revisit_shader name variable)
    set(folder ${CMAKE_CURRENT_SOURCE_DIR}/shaders)
    if(ARGC GREATER 2)
        set(folder ${ARGV2})
    endif()
    set(header ${CMAKE_CURRENT_BINARY_DIR}/spirv/${name}.h)
    file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/spirv)
    add_custom_command(OUTPUT ${header}
        COMMAND ${GLSLANG} -V -Os --quiet --target-env vulkan1.2 -I${CMAKE_SOURCE_DIR} --vn ${variable}
                --depfile ${header}.d -o ${header} ${folder}/${name}
        DEPENDS ${folder}/${name}
        DEPFILE ${header}.d
        COMMENT "Compiling shader ${name}"
        VERBATIM)
    if(NOT TARGET shader_headers) # all of them, for what reads sources without building (./dev lint)
        add_custom_target(shader_headers)
    endif()
    add_custom_target(header_${name} DEPENDS ${header})
    add_dependencies(shader_headers header_${name})
    list(APPEND REVISIT_SHADER_HEADERS ${header})
    set(REVISIT_SHADER_HEADERS ${REVISIT_SHADER_HEADERS} PARENT_SCOPE)
endfunction()
