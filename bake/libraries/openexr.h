// SPDX-License-Identifier: Apache-2.0
/// OpenEXR 3.1 to 3.4, for reading.
#pragma once

#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#if __has_include(<OpenEXR/ImfContextInit.h>)
#include <OpenEXR/ImfContextInit.h>
#endif

namespace photic {

/// The parts of an EXR file. `stream` must outlive what is returned.
/// From 3.3 on OpenEXR prints what is wrong with a file, too; here it only throws, and who catches that says it once.
/// @throws std::exception where the file is damaged
inline Imf::MultiPartInputFile openExr(Imf::IStream& stream) {
#if __has_include(<OpenEXR/ImfContextInit.h>)
    const auto say_nothing = [](exr_const_context_t, exr_result_t, const char*) {};
    return Imf::MultiPartInputFile(stream.fileName(), Imf::ContextInitializer()
                                                          .setInputStream(&stream)
                                                          .silentHeaderParse(true)
                                                          .strictHeaderValidation(false)
                                                          .setErrorHandler(say_nothing));
#else
    return Imf::MultiPartInputFile(stream);
#endif
}

}  // namespace photic
