// The pixels of an EXR file against its header.
#pragma once

#include "file/byte_source.h"
#include "image/exr_header.h"

namespace pvol::formats::detail {

/// OpenEXR does not notice where a block of pixels is shorter than its header says, as it is stored
/// or once zip or runs are unpacked: the rest of it is what happened to be in memory. Unpacks all
/// blocks of the parts that a film is read from, of full size where there are several, and throws
/// Error for one of another size, or one that is cut off. The parts' windows and blocks were
/// checked before.
void check_blocks(ByteSource& source, const ExrHeaders& headers);

}  // namespace pvol::formats::detail
