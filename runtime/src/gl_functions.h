// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <GL/glcorearb.h>

#include <optional>
#include <string>

#include "photic/gl_context.h"
#include "photic/result.h"

namespace photic::runtime {

// Every GL function that the library calls, with the type of its pointer. A list, so that the table, its loading and
// the message about what is missing are one thing. All are in GL 4.3 and in ES 3.1 unless listed as optional.
#define PHOTIC_GL_FUNCTIONS(F)                            \
    F(ActiveTexture, ACTIVETEXTURE)                       \
    F(AttachShader, ATTACHSHADER)                         \
    F(BeginQuery, BEGINQUERY)                             \
    F(BindBuffer, BINDBUFFER)                             \
    F(BindBufferBase, BINDBUFFERBASE)                     \
    F(BindBufferRange, BINDBUFFERRANGE)                   \
    F(BindFramebuffer, BINDFRAMEBUFFER)                   \
    F(BindSampler, BINDSAMPLER)                           \
    F(BindTexture, BINDTEXTURE)                           \
    F(BindVertexArray, BINDVERTEXARRAY)                   \
    F(BlendColor, BLENDCOLOR)                             \
    F(BlendEquationSeparate, BLENDEQUATIONSEPARATE)       \
    F(BlendFuncSeparate, BLENDFUNCSEPARATE)               \
    F(BlitFramebuffer, BLITFRAMEBUFFER)                   \
    F(BufferData, BUFFERDATA)                             \
    F(BufferSubData, BUFFERSUBDATA)                       \
    F(CheckFramebufferStatus, CHECKFRAMEBUFFERSTATUS)     \
    F(Clear, CLEAR)                                       \
    F(ClearBufferfv, CLEARBUFFERFV)                       \
    F(ClearColor, CLEARCOLOR)                             \
    F(ClearDepthf, CLEARDEPTHF)                           \
    F(ColorMask, COLORMASK)                               \
    F(CompileShader, COMPILESHADER)                       \
    F(CompressedTexSubImage3D, COMPRESSEDTEXSUBIMAGE3D)   \
    F(CreateProgram, CREATEPROGRAM)                       \
    F(CreateShader, CREATESHADER)                         \
    F(CullFace, CULLFACE)                                 \
    F(DeleteBuffers, DELETEBUFFERS)                       \
    F(DeleteFramebuffers, DELETEFRAMEBUFFERS)             \
    F(DeleteProgram, DELETEPROGRAM)                       \
    F(DeleteQueries, DELETEQUERIES)                       \
    F(DeleteSamplers, DELETESAMPLERS)                     \
    F(DeleteShader, DELETESHADER)                         \
    F(DeleteSync, DELETESYNC)                             \
    F(DeleteTextures, DELETETEXTURES)                     \
    F(DeleteVertexArrays, DELETEVERTEXARRAYS)             \
    F(DepthFunc, DEPTHFUNC)                               \
    F(DepthMask, DEPTHMASK)                               \
    F(DetachShader, DETACHSHADER)                         \
    F(Disable, DISABLE)                                   \
    F(DisableVertexAttribArray, DISABLEVERTEXATTRIBARRAY) \
    F(DrawArrays, DRAWARRAYS)                             \
    F(DrawArraysInstanced, DRAWARRAYSINSTANCED)           \
    F(DrawBuffers, DRAWBUFFERS)                           \
    F(DrawElements, DRAWELEMENTS)                         \
    F(DrawElementsInstanced, DRAWELEMENTSINSTANCED)       \
    F(Enable, ENABLE)                                     \
    F(EnableVertexAttribArray, ENABLEVERTEXATTRIBARRAY)   \
    F(EndQuery, ENDQUERY)                                 \
    F(FenceSync, FENCESYNC)                               \
    F(ClientWaitSync, CLIENTWAITSYNC)                     \
    F(Finish, FINISH)                                     \
    F(Flush, FLUSH)                                       \
    F(FramebufferTexture2D, FRAMEBUFFERTEXTURE2D)         \
    F(FramebufferTextureLayer, FRAMEBUFFERTEXTURELAYER)   \
    F(FrontFace, FRONTFACE)                               \
    F(GenBuffers, GENBUFFERS)                             \
    F(GenFramebuffers, GENFRAMEBUFFERS)                   \
    F(GenQueries, GENQUERIES)                             \
    F(GenSamplers, GENSAMPLERS)                           \
    F(GenTextures, GENTEXTURES)                           \
    F(GenVertexArrays, GENVERTEXARRAYS)                   \
    F(GenerateMipmap, GENERATEMIPMAP)                     \
    F(GetBooleanv, GETBOOLEANV)                           \
    F(GetError, GETERROR)                                 \
    F(GetFloatv, GETFLOATV)                               \
    F(GetInteger64i_v, GETINTEGER64I_V)                   \
    F(GetInteger64v, GETINTEGER64V)                       \
    F(GetIntegeri_v, GETINTEGERI_V)                       \
    F(GetIntegerv, GETINTEGERV)                           \
    F(GetProgramInfoLog, GETPROGRAMINFOLOG)               \
    F(GetProgramiv, GETPROGRAMIV)                         \
    F(GetQueryObjectuiv, GETQUERYOBJECTUIV)               \
    F(GetShaderInfoLog, GETSHADERINFOLOG)                 \
    F(GetShaderiv, GETSHADERIV)                           \
    F(GetString, GETSTRING)                               \
    F(GetStringi, GETSTRINGI)                             \
    F(GetTexLevelParameteriv, GETTEXLEVELPARAMETERIV)     \
    F(GetUniformBlockIndex, GETUNIFORMBLOCKINDEX)         \
    F(GetUniformLocation, GETUNIFORMLOCATION)             \
    F(IsEnabled, ISENABLED)                               \
    F(LinkProgram, LINKPROGRAM)                           \
    F(MapBufferRange, MAPBUFFERRANGE)                     \
    F(PixelStorei, PIXELSTOREI)                           \
    F(PolygonOffset, POLYGONOFFSET)                       \
    F(ReadBuffer, READBUFFER)                             \
    F(ReadPixels, READPIXELS)                             \
    F(SamplerParameterf, SAMPLERPARAMETERF)               \
    F(SamplerParameteri, SAMPLERPARAMETERI)               \
    F(Scissor, SCISSOR)                                   \
    F(ShaderSource, SHADERSOURCE)                         \
    F(TexParameteri, TEXPARAMETERI)                       \
    F(TexStorage2D, TEXSTORAGE2D)                         \
    F(TexStorage3D, TEXSTORAGE3D)                         \
    F(TexSubImage2D, TEXSUBIMAGE2D)                       \
    F(TexSubImage3D, TEXSUBIMAGE3D)                       \
    F(Uniform1f, UNIFORM1F)                               \
    F(Uniform1fv, UNIFORM1FV)                             \
    F(Uniform1i, UNIFORM1I)                               \
    F(Uniform1ui, UNIFORM1UI)                             \
    F(Uniform2f, UNIFORM2F)                               \
    F(Uniform2i, UNIFORM2I)                               \
    F(Uniform3f, UNIFORM3F)                               \
    F(Uniform3fv, UNIFORM3FV)                             \
    F(Uniform3i, UNIFORM3I)                               \
    F(Uniform4f, UNIFORM4F)                               \
    F(Uniform4fv, UNIFORM4FV)                             \
    F(Uniform4i, UNIFORM4I)                               \
    F(UniformBlockBinding, UNIFORMBLOCKBINDING)           \
    F(UniformMatrix3fv, UNIFORMMATRIX3FV)                 \
    F(UniformMatrix4fv, UNIFORMMATRIX4FV)                 \
    F(UnmapBuffer, UNMAPBUFFER)                           \
    F(UseProgram, USEPROGRAM)                             \
    F(VertexAttribDivisor, VERTEXATTRIBDIVISOR)           \
    F(VertexAttribIPointer, VERTEXATTRIBIPOINTER)         \
    F(VertexAttribPointer, VERTEXATTRIBPOINTER)           \
    F(Viewport, VIEWPORT)

// Not in every context that is good enough: may be null, or of no use though there is a pointer. GlFunctions says what
// may be called.
#define PHOTIC_GL_OPTIONAL_FUNCTIONS(F)               \
    F(BindImageTexture, BINDIMAGETEXTURE)             \
    F(BlendEquationSeparatei, BLENDEQUATIONSEPARATEI) \
    F(BlendFuncSeparatei, BLENDFUNCSEPARATEI)         \
    F(ClipControl, CLIPCONTROL)                       \
    F(ColorMaski, COLORMASKI)                         \
    F(Disablei, DISABLEI)                             \
    F(DispatchCompute, DISPATCHCOMPUTE)               \
    F(Enablei, ENABLEI)                               \
    F(GetBooleani_v, GETBOOLEANI_V)                   \
    F(GetFloati_v, GETFLOATI_V)                       \
    F(GetGraphicsResetStatus, GETGRAPHICSRESETSTATUS) \
    F(GetQueryObjectui64v, GETQUERYOBJECTUI64V)       \
    F(GetTexImage, GETTEXIMAGE)                       \
    F(IsEnabledi, ISENABLEDI)                         \
    F(MemoryBarrier, MEMORYBARRIER)                   \
    F(PolygonMode, POLYGONMODE)                       \
    F(ScissorIndexed, SCISSORINDEXED)                 \
    F(ViewportIndexedf, VIEWPORTINDEXEDF)

/// The GL of one context (or of a share group): its functions, named as in GL without the `gl`, and what it can do.
struct GlFunctions {
#define PHOTIC_GL_MEMBER(name, type) PFNGL##type##PROC name = nullptr;
    PHOTIC_GL_FUNCTIONS(PHOTIC_GL_MEMBER)
    PHOTIC_GL_OPTIONAL_FUNCTIONS(PHOTIC_GL_MEMBER)
#undef PHOTIC_GL_MEMBER

    bool es = false;             ///< OpenGL ES
    int major = 0, minor = 0;    ///< version
    std::string renderer;        ///< GL_RENDERER, for messages and tables
    int largest_texture_3d = 0;  ///< [texels a side]
    int largest_texture_2d = 0;
    GLint64 largest_storage_block = 0;  ///< [bytes]
    bool bc6h = false;                  ///< textures of it, in three dimensions too
    bool computes = false;              ///< compute shaders and what they write to
    bool clip_control = false;          ///< ClipControl
    bool resets = false;                ///< GetGraphicsResetStatus
    bool viewports = false;             ///< ViewportIndexedf, ScissorIndexed, and tests of each
    GLuint draw_buffers = 1;  ///< that have blending and a mask of their own; 1: the functions with an i are not there

    /// The first viewport; glViewport sets all that a game has.
    void setViewport(GLint x, GLint y, GLsizei width, GLsizei height) const;

    /// Error{Lost} where the context is lost, as far as it tells, or none is current; otherwise nothing.
    std::optional<Error> lost() const;
    /// Forgets errors that are pending, ours or the game's: what glErrors() returns next is of calls in between.
    void clearErrors() const;
    /// The first pending error, GL_NO_ERROR when none; forgets the rest.
    GLenum firstError() const;
};

/// Fills the table. The context must be current.
/// @return Error{Unsupported} for less than GL 4.3 or ES 3.1, or naming the functions that are missing
Result<GlFunctions> loadGlFunctions(const GlLoader& loader);

}  // namespace photic::runtime
