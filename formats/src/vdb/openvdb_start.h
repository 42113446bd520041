// OpenVDB must be told which types of grids there are before it reads or writes any.
#pragma once

namespace pvol::formats::detail {

/// Does so once, whichever thread calls first.
void start_openvdb();

}  // namespace pvol::formats::detail
