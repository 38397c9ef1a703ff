/** The page's texts did not come, so that it says this in every language. */
export function PageMissing() {
  return (
    <main class="startup">
      <p>The page could not be loaded. Check your connection and reload it.</p>
      <p lang="zh-CN">页面加载失败，请检查网络后刷新。</p>
      <button type="button" class="button main" onClick={() => location.reload()}>
        Reload / <span lang="zh-CN">刷新</span>
      </button>
    </main>
  );
}
