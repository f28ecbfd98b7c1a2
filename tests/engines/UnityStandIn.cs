// SPDX-License-Identifier: Apache-2.0
// What PhoticVolume.cs uses of Unity, with Unity's meaning, so that the script itself can be run: Main starts the component as
// Unity would, and writes what shaders would then see. Texels lie as Texture3D.SetPixels takes them, x fastest.
using System;
using System.IO;
using System.Reflection;

namespace UnityEngine
{
    public class TooltipAttribute : Attribute { public TooltipAttribute(string text) { } }
    public class MonoBehaviour { }
    public static class Application { public static string streamingAssetsPath; }
    public struct Color { public float r, g, b, a; public Color(float r, float g, float b, float a) { this.r = r; this.g = g; this.b = b; this.a = a; } }
    public struct Vector4 { public float x, y, z, w; public Vector4(float x, float y, float z, float w) { this.x = x; this.y = y; this.z = z; this.w = w; } }
    public enum TextureFormat { RGBAHalf }
    public enum TextureWrapMode { Repeat, Clamp }
    public enum FilterMode { Point, Bilinear }

    public class Texture3D
    {
        public int width, height, depth;
        public Color[] colors;
        public bool applied;
        public TextureWrapMode wrapMode;
        public FilterMode filterMode;
        public Texture3D(int width, int height, int depth, TextureFormat format, bool mipmaps) { this.width = width; this.height = height; this.depth = depth; }
        public void SetPixels(Color[] colors)
        {
            if (colors.Length != width * height * depth) throw new ArgumentException("SetPixels: " + colors.Length + " colours");
            this.colors = colors;
        }
        public void Apply(bool mipmaps, bool no_longer_readable) { applied = true; }
    }

    /// this[row, column], of column vectors.
    public struct Matrix4x4
    {
        float[] values;
        float[] Values { get { return values ?? (values = new float[16]); } }
        public float this[int row, int column] { get { return Values[4 * row + column]; } set { Values[4 * row + column] = value; } }
        public Matrix4x4 inverse
        {
            get
            {
                // By Gauss and Jordan, the largest of each column first.
                var m = new double[4, 8];
                for (int i = 0; i < 4; ++i) for (int j = 0; j < 4; ++j) { m[i, j] = this[i, j]; m[i, 4 + j] = i == j ? 1 : 0; }
                for (int c = 0; c < 4; ++c)
                {
                    int best = c;
                    for (int i = c + 1; i < 4; ++i) if (Math.Abs(m[i, c]) > Math.Abs(m[best, c])) best = i;
                    for (int j = 0; j < 8; ++j) { double t = m[c, j]; m[c, j] = m[best, j]; m[best, j] = t; }
                    double pivot = m[c, c];
                    for (int j = 0; j < 8; ++j) m[c, j] /= pivot;
                    for (int i = 0; i < 4; ++i)
                    {
                        double factor = m[i, c];
                        if (i != c) for (int j = 0; j < 8; ++j) m[i, j] -= factor * m[c, j];
                    }
                }
                var inverse = new Matrix4x4();
                for (int i = 0; i < 4; ++i) for (int j = 0; j < 4; ++j) inverse[i, j] = (float)m[i, 4 + j];
                return inverse;
            }
        }
    }

    public static class Shader
    {
        public static Texture3D light;
        public static Vector4 size;
        public static Matrix4x4 texture_from_world;
        static void Expect(string name, string given) { if (name != given) throw new ArgumentException("Photic.hlsl knows no " + given); }
        public static void SetGlobalTexture(string name, Texture3D value) { Expect("_PhoticLight", name); light = value; }
        public static void SetGlobalVector(string name, Vector4 value) { Expect("_PhoticSize", name); size = value; }
        public static void SetGlobalMatrix(string name, Matrix4x4 value) { Expect("_PhoticTextureFromWorld", name); texture_from_world = value; }
    }

    public static class Program
    {
        public static void Main(string[] arguments)     // FOLDER FILE OUTPUT
        {
            Application.streamingAssetsPath = arguments[0];
            var component = new PhoticVolume { file = arguments[1] };
            typeof(PhoticVolume).GetMethod("Start", BindingFlags.Instance | BindingFlags.NonPublic).Invoke(component, null);
            if (!Shader.light.applied || Shader.light.wrapMode != TextureWrapMode.Clamp || Shader.light.filterMode != FilterMode.Bilinear)
                throw new Exception("the texture is not as Photic.hlsl reads it");
            using (var output = new BinaryWriter(File.Create(arguments[2])))
            {
                output.Write(Shader.light.width); output.Write(Shader.light.height); output.Write(Shader.light.depth);
                output.Write(Shader.size.x); output.Write(Shader.size.y); output.Write(Shader.size.z);
                for (int i = 0; i < 16; ++i) output.Write(Shader.texture_from_world[i / 4, i % 4]);
                foreach (var c in Shader.light.colors) { output.Write(c.r); output.Write(c.g); output.Write(c.b); output.Write(c.a); }
            }
        }
    }
}
