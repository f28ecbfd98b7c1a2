// SPDX-License-Identifier: Apache-2.0
// Unity: reads NAME_flux.vf and NAME.vf of `photic export` into one texture, and gives it to all shaders.
using System;
using System.Globalization;
using System.IO;
using System.Text.RegularExpressions;
using UnityEngine;

public class PhoticVolume : MonoBehaviour
{
    [Tooltip("NAME.vf in StreamingAssets; NAME_flux.vf and NAME.vf.json lie beside it")]
    public string file = "pool.vf";

    void Start()
    {
        string path = Path.Combine(Application.streamingAssetsPath, file);
        byte[] irradiance = File.ReadAllBytes(path);
        byte[] flux = File.ReadAllBytes(Path.ChangeExtension(path, null) + "_flux.vf");
        // "VF_F" or "VF_V", then x, y, z as 16-bit numbers, then floats, x fastest (docs/files.md).
        int x = BitConverter.ToUInt16(irradiance, 4), y = BitConverter.ToUInt16(irradiance, 6), z = BitConverter.ToUInt16(irradiance, 8);
        var texels = new Color[x * y * z];
        for (int i = 0; i < texels.Length; ++i)
        {
            texels[i] = new Color(BitConverter.ToSingle(flux, 10 + 12 * i), BitConverter.ToSingle(flux, 14 + 12 * i),
                                  BitConverter.ToSingle(flux, 18 + 12 * i), BitConverter.ToSingle(irradiance, 10 + 4 * i));
        }
        var texture = new Texture3D(x, y, z, TextureFormat.RGBAHalf, false) { wrapMode = TextureWrapMode.Clamp, filterMode = FilterMode.Bilinear };
        texture.SetPixels(texels);
        texture.Apply(false, true);
        Shader.SetGlobalTexture("_PhoticLight", texture);
        Shader.SetGlobalVector("_PhoticSize", new Vector4(x, y, z, 0));
        Shader.SetGlobalMatrix("_PhoticTextureFromWorld", WorldFromTexture(File.ReadAllText(path + ".json")).inverse);
    }

    // "world_from_texture": four rows of four. JsonUtility knows no nested arrays: take the sixteen numbers that follow.
    static Matrix4x4 WorldFromTexture(string json)
    {
        string rest = json.Substring(json.IndexOf("\"world_from_texture\"") + "\"world_from_texture\"".Length);
        var numbers = Regex.Matches(rest, @"-?\d+(\.\d+)?([eE][-+]?\d+)?");
        var matrix = new Matrix4x4();
        for (int i = 0; i < 16; ++i) matrix[i / 4, i % 4] = float.Parse(numbers[i].Value, CultureInfo.InvariantCulture);
        return matrix;
    }
}
