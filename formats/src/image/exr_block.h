// The first pixels of an EXR file against its header.
#pragma once

#include "file/byte_source.h"
#include "image/exr_header.h"

namespace pvol::formats::detail {

/// OpenEXR does not notice where a block of pixels that zlib compressed is shorter than its header
/// says: the rest of the picture is what happened to be in memory. A header that does not belong to
/// the pixels shows in the first block already. Throws Error where that has another size.
void check_first_block(ByteSource& source, const ExrHeaders& headers);

}  // namespace pvol::formats::detail
