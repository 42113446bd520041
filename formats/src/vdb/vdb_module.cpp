// What pvol_vdb.so shows: all else in it is hidden.
#include "vdb/vdb_calls.h"

extern "C" [[gnu::visibility("default")]] const pvol::formats::detail::VdbCalls pvol_vdb_calls;

const pvol::formats::detail::VdbCalls pvol_vdb_calls{
    pvol::formats::detail::read_vdb_density, pvol::formats::detail::read_vdb_color,
    pvol::formats::detail::read_vdb_velocity, pvol::formats::detail::vdb_writer};
