# find_package(narx): the target narx::narx, header and static library; for a microcontroller also
# narx::small, the same in less flash and with slower ticks.
#
#   NARX_TARGET    selects the library by Rust's name of its target: a folder of lib/. Without it
#                  CMAKE_SYSTEM_PROCESSOR selects: cortex-m0, m0plus, m1 and m23; cortex-m3; cortex-m4 and
#                  m7, and cortex-m33, m35p, m55 and m85 (these with floating point in hardware); riscv32;
#                  or this machine. Without floating point these take thumbv7m-none-eabi.

get_filename_component(_narx_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT DEFINED NARX_TARGET)
    if(CMAKE_SYSTEM_PROCESSOR MATCHES "^cortex-m(0|0plus|1|23)$")
        set(NARX_TARGET thumbv6m-none-eabi)
    elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^cortex-m3$")
        set(NARX_TARGET thumbv7m-none-eabi)
    elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^cortex-m[47]")
        set(NARX_TARGET thumbv7em-none-eabihf)
    elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^cortex-m(33|35p|55|85)")
        set(NARX_TARGET thumbv8m.main-none-eabihf)
    elseif(CMAKE_SYSTEM_PROCESSOR MATCHES "^riscv32")
        set(NARX_TARGET riscv32imac-unknown-none-elf)
    elseif(CMAKE_SYSTEM_NAME STREQUAL "Linux" AND CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
        set(NARX_TARGET x86_64-unknown-linux-gnu)
    else()
        set(NARX_TARGET "")
    endif()
endif()

set(_narx_library "${_narx_prefix}/lib/${NARX_TARGET}/libnarx.a")
if("${NARX_TARGET}" STREQUAL "" OR NOT EXISTS "${_narx_library}")
    file(GLOB _narx_targets RELATIVE "${_narx_prefix}/lib" "${_narx_prefix}/lib/*-*")
    set(narx_FOUND FALSE)
    set(narx_NOT_FOUND_MESSAGE
        "no library for NARX_TARGET '${NARX_TARGET}' (CMAKE_SYSTEM_PROCESSOR '${CMAKE_SYSTEM_PROCESSOR}'); there are: ${_narx_targets}")
    return()
endif()

if(NOT TARGET narx::narx)
    # GLOBAL: FetchContent includes this file in a folder below the project's.
    add_library(narx::narx STATIC IMPORTED GLOBAL)
    set_target_properties(narx::narx PROPERTIES
        IMPORTED_LOCATION "${_narx_library}"
        INTERFACE_INCLUDE_DIRECTORIES "${_narx_prefix}/include")
    if(EXISTS "${_narx_prefix}/lib/${NARX_TARGET}/libnarx-small.a")
        add_library(narx::small STATIC IMPORTED GLOBAL)
        set_target_properties(narx::small PROPERTIES
            IMPORTED_LOCATION "${_narx_prefix}/lib/${NARX_TARGET}/libnarx-small.a"
            INTERFACE_INCLUDE_DIRECTORIES "${_narx_prefix}/include")
    endif()
    # On a host the library contains Rust's standard library, but uses only its panic handler.
    if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
        set_property(TARGET narx::narx PROPERTY INTERFACE_LINK_LIBRARIES pthread dl m)
    endif()
endif()
